// Python and all packages of the course at once: the kernel takes this file for Pyodide's own (tools/build_lite.py).
//
// Pyodide would fetch sixty wheels, let Python unpack each of them, and load every library in them, a hundred and fifty.
// Here the browser unpacks one image, `course-0.image` and so on, while Python starts; a library is loaded when it is imported.
// What every notebook needs is imported before the files of the student are there, and later imports look among them
// last: each look is a question to the page.
//
// `ahead.js` has called `loadPyodide` before the kernel asks for it: the kernel gets that Python.
globalThis.loadPyodide = async ({ packages, ...options }) => (globalThis.begun ??= started(options));

async function started(options) {
  // These two stop the thread until they are here, so they come first. A browser has six connections to a host: parts of
  // the image could hold them all, and a thread that is stopped takes nothing from them. It would wait for ever.
  const ours = globalThis.loadPyodide;
  importScripts(options.indexURL + "pyodide.js"); // puts Pyodide's own function in the place of this file's
  const pyodides = globalThis.loadPyodide;
  globalThis.loadPyodide = ours;
  importScripts(options.indexURL + "pyodide.asm.js"); // which need not be loaded then
  const names = Array.from({ length: PARTS }, (_, k) => `course-${k}.image`);
  const image = Promise.all(names.map(name => part(options.indexURL + name))).then(plain);
  const python = await pyodides(options);
  await layDown(python, await image);
  python.runPython(`
import gc, sys
gc.set_threshold(50_000)  # a page has memory; to look for rubbish often takes time
import pyodide_kernel, ekfslam_tutorial.course, matplotlib.pyplot
sys.path.sort(key=lambda folder: folder == "")
`);
  return python;
}

async function part(url) {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url}: ${answer.statusText}`);
  return answer.blob();
}

async function plain(parts) {
  const unpacked = new Blob(parts).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(unpacked).arrayBuffer());
}

// An image: the length of its list, the list [[path, bytes], ...], and the files, one behind the other.
globalThis.layDown = async ({ FS, loadedPackages, _api }, image) => {
  const start = 4 + new DataView(image.buffer, image.byteOffset).getUint32(0, true);
  const files = JSON.parse(new TextDecoder().decode(image.subarray(4, start)));
  const folders = new Set();
  let place = start;
  for (const [path, size] of files) {
    const folder = path.slice(0, path.lastIndexOf("/"));
    if (!folders.has(folder)) FS.mkdirTree(folder);
    folders.add(folder);
    FS.writeFile(path, image.subarray(place, place + size), { canOwn: true });
    place += size;
  }
  for (const { name } of Object.values(_api.lockfile_packages)) loadedPackages[name] = "default channel";
  for (const [path] of files) if (path.startsWith("/usr/lib/")) await _api.loadDynlib(path, false, []); // others need it
};
