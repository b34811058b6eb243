// node run.mjs SITE SCRIPT WORD...: run a Python file in the Pyodide of a built site, without a browser.
// The file sees the files of this computer below /host, and the words in sys.argv.
import { readdirSync, readFileSync } from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import vm from "node:vm";
import { gunzipSync } from "node:zlib";

const [site, script, ...words] = process.argv.slice(2);
const pyodide = path.resolve(site, "pyodide");
const { loadPyodide } = await import(pathToFileURL(path.join(pyodide, "pyodide.mjs")));
const python = await loadPyodide({ indexURL: pyodide + path.sep, env: { HOME: "/home/pyodide", ...settings() } });
const image = readdirSync(pyodide).filter(name => name.endsWith(".image")).sort();
if (image.length) {
  vm.runInThisContext(readFileSync(path.join(pyodide, "start.js")));
  await globalThis.layDown(python, gunzipSync(Buffer.concat(image.map(name => readFileSync(path.join(pyodide, name))))));
} else {
  await python.loadPackage(packages(), { messageCallback: () => {} }); // while the site is built
}
python.FS.mkdir("/host");
python.FS.mount(python.FS.filesystems.NODEFS, { root: path.parse(pyodide).root }, "/host");
python.globals.set("words", python.toPy(["/host" + path.resolve(script), ...words]));
try {
  python.runPython(`
import runpy, site, sys
runpy.run_path(site.getsitepackages()[0] + "/pyodide_kernel/mocks.py")["apply_mocks"]()  # as in a notebook
sys.argv = list(words)
runpy.run_path(sys.argv[0], run_name="__main__")
`);
} catch (error) {
  console.error(error.message);
  process.exitCode = 1;
}

// Those that the kernel loads in the browser, as far as the site has them yet.
function packages() {
  const read = name => JSON.parse(readFileSync(path.join(site, name)));
  const known = read("pyodide/pyodide-lock.json").packages;
  const { litePluginSettings } = read("jupyter-lite.json")["jupyter-config-data"];
  const { loadPyodideOptions } = litePluginSettings["@jupyterlite/pyodide-kernel-extension:kernel"];
  return loadPyodideOptions.packages.filter(name => name.replaceAll("_", "-") in known);
}

function settings() {
  return Object.fromEntries(Object.entries(process.env).filter(([name]) => name.startsWith("EKFSLAM_")));
}
