// What the page does before its own programs come (tools/build_lite.py): it begins Python, and unpacks the programs.
const here = new URL(".", import.meta.url);
beginPython();

// Many servers of files do not pack what they send; the page would load 8 MB in 120 pieces before Python starts.
// A program that lies in the image, `page.image`, comes from there, all others come as ever.
const answer = await fetch(new URL("page.image", here));
const unpacked = answer.body.pipeThrough(new DecompressionStream("gzip"));
const programs = await new Response(unpacked).json();
const places = new Map(
  Object.entries(programs).map(([path, text]) => [
    new URL(path, here).href,
    URL.createObjectURL(new Blob([text], { type: "text/javascript" })),
  ]),
);
const plain = Object.getOwnPropertyDescriptor(HTMLScriptElement.prototype, "src");
Object.defineProperty(HTMLScriptElement.prototype, "src", {
  ...plain,
  set(url) {
    const whole = new URL(url, document.baseURI);
    plain.set.call(this, places.get(whole.origin + whole.pathname) ?? url);
  },
});

// The thread of the first kernel is begun here, and handed over when the kernel makes it. It must be under the service
// worker, through which Python reaches the student's files: at the first visit that comes with JupyterLab, at all
// others it is there.
function beginPython() {
  const Plain = window.Worker, { serviceWorker } = navigator;
  const kernel = url => new URL(url, document.baseURI).pathname.endsWith("/KERNEL");
  let begun = null, asked = crossOriginIsolated; // then the kernel has another program
  const begin = () => { if (!asked) begun ??= new Plain(new URL("pyodide/ahead.js", here)); };
  window.Worker = class extends Plain {
    constructor(url, options) {
      if (!kernel(url) || asked) return super(url, options);
      asked = true;
      return begun ?? super(url, options);
    }
  };
  if (!serviceWorker || serviceWorker.controller) begin();
  else serviceWorker.addEventListener("controllerchange", begin, { once: true });
}
