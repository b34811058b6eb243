// The programs of the page as one packed file, `page.image` (tools/build_lite.py): the page imports this before its own.
//
// Many servers of files do not pack what they send; the page would load 8 MB in 120 pieces before Python starts.
// A program that lies in the image comes from there, all others come as ever.
const here = new URL(".", import.meta.url);
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
