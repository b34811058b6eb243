// The program of the kernel's thread, where the page begins it before JupyterLab is there (page.js): both then start at
// the same time, on two cores. It is JupyterLite's own, and a Python that is under way when the kernel asks for it.
importScripts("../KERNEL", "start.js"); // the thread stands still until they are here: first, see start.js
const load = importScripts;
globalThis.importScripts = (...urls) => load(...urls.filter(url => !url.endsWith("/start.js"))); // not a second time
globalThis.loadPyodide({ indexURL: new URL(".", location).href, ...OPTIONS });
