// Two entries of the file menu: "Download my work" and "Take up my work"; and on a phone room for the notebook.
//
// JupyterLite keeps what a student writes in the browser's own storage, where no other computer finds it. The first
// entry packs all files that are not as the site delivers them (notebooks, my_slam.py, progress.json) into my_work.zip;
// the second puts such a file, or a single notebook, back. The cells `take_home()` and `take_up()` press these buttons.
//
// And for those who hear the page: what JupyterLab leaves without a name, or names wrongly, gets one.
//
// This file is an extension of JupyterLab as webpack would write one: a container with `init` and `get`.
"use strict";
(() => {
  const NAME = "ekfslam-work", ZIP = "my_work.zip", TWIN = "progress.backup.json"; // the same records once more
  const NARROW = 700; // CSS pixels
  let scope;

  async function shared(name) {
    const versions = Object.values(scope[name]);
    return (await versions[versions.length - 1].get())();
  }

  async function get() {
    const { IMainMenu } = await shared("@jupyterlab/mainmenu");
    const plugin = { id: `${NAME}:plugin`, autoStart: true, optional: [IMainMenu], activate };
    return () => ({ __esModule: true, default: plugin });
  }

  function activate(app, menu) {
    app.commands.addCommand("ekfslam:take-home", { label: "Download my work", execute: () => takeHome(app) });
    app.commands.addCommand("ekfslam:take-up", { label: "Take up my work…", execute: () => choose(app) });
    menu?.fileMenu.addGroup([{ command: "ekfslam:take-home" }, { command: "ekfslam:take-up" }], 1);
    // A key pressed on a slider is for the slider: ArrowRight must not go to the notebook's next heading as well.
    window.addEventListener("keydown", ({ target }) => {
      if (target.closest?.(".jupyter-widgets")) target.setAttribute("data-lm-suppress-shortcuts", "true");
    }, true);
    if (innerWidth < NARROW) app.restored.then(() => giveRoom(app));
    app.shell.currentChanged?.connect(() => noteInAddress(app.shell.currentWidget));
    app.restored.then(() => {
      noteInAddress(app.shell.currentWidget);
      let soon;
      const changed = () => (soon ??= setTimeout(() => (name(), (soon = null)), 500));
      new MutationObserver(changed).observe(document.body, { childList: true, subtree: true });
      changed();
    });
  }

  // A page that is loaded again shows what was open: JupyterLab takes the name out of the address and forgets it.
  function noteInAddress(widget) {
    const address = new URL(location), path = widget?.context?.path;
    if (!path) return;
    address.searchParams.set("path", path);
    history.replaceState(history.state, "", address);
  }

  // What a reader of the screen needs and JupyterLab 4.4 does not say (axe finds it).
  function name() {
    const each = (selector, change) => document.querySelectorAll(selector).forEach(change);
    each(".cm-content:not([aria-label])", cell => cell.setAttribute("aria-label", "Text of the cell"));
    each(".jp-collapseHeadingButton:not([aria-label])", button => button.setAttribute("aria-label", "Fold this section"));
    each("jp-button[aria-pressed=false]", button => button.removeAttribute("aria-pressed")); // the button is inside of it
    each("[role=feed]", cells => cells.setAttribute("role", "group")); // a feed would consist of articles only
    each(".jp-RenderedMarkdown, .cm-scroller", part => {
      if (part.tabIndex < 0 && part.scrollWidth > part.clientWidth) part.tabIndex = 0; // to be scrolled by keys
    });
  }

  // On a phone the list of files and the room for numbers of cells would leave a notebook a tenth of the window.
  // JupyterLab opens the list more than once while it starts; who taps on it wants to see it.
  function giveRoom(app) {
    let touched = false;
    window.addEventListener("pointerdown", () => (touched = true), { capture: true, once: true });
    const collapse = () => touched || app.shell.leftCollapsed || app.shell.collapseLeft();
    app.shell.layoutModified.connect(collapse);
    collapse();
    const root = document.documentElement.style;
    root.setProperty("--jp-cell-prompt-width", "12px");
    root.setProperty("--jp-notebook-padding", "2px");
  }

  // ---- out ----

  async function takeHome(app) {
    await app.commands.execute("docmanager:save-all");
    const files = {};
    for (const path of await paths(app.serviceManager.contents, "")) {
      const text = asText(await app.serviceManager.contents.get(path, { content: true }));
      if (path !== TWIN && text !== (await delivered(app, path))) files[path] = new TextEncoder().encode(text);
    }
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([zip(files)], { type: "application/zip" }));
    link.download = ZIP;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
    return Object.keys(files);
  }

  async function paths(contents, folder) {
    const found = [];
    for (const item of (await contents.get(folder, { content: true })).content) {
      if (item.type === "directory") found.push(...(await paths(contents, item.path)));
      else found.push(item.path);
    }
    return found;
  }

  function asText({ type, format, content }) {
    if (type === "notebook" || format === "json") return JSON.stringify(content, null, 1) + "\n";
    return format === "base64" ? atob(content) : content;
  }

  // A file as the site delivers it, or null.
  async function delivered(app, path) {
    const { baseUrl } = app.serviceManager.serverSettings;
    const all = await listed(baseUrl, path.split("/").slice(0, -1).join("/"));
    if (!all.includes(path)) return null;
    const answer = await fetch(`${baseUrl}files/${path.split("/").map(encodeURIComponent).join("/")}`);
    const text = await answer.text();
    return path.endsWith(".ipynb") ? JSON.stringify(JSON.parse(text), null, 1) + "\n" : text;
  }

  async function listed(baseUrl, folder) {
    const answer = await fetch(`${baseUrl}api/contents/${folder ? folder + "/" : ""}all.json`);
    return answer.ok ? (await answer.json()).content.map(item => item.path) : [];
  }

  // ---- in ----

  function choose(app) {
    const input = document.createElement("input");
    input.type = "file";
    input.accept = ".zip,.ipynb,.py,.json,.toml";
    const done = new Promise(resolve => {
      input.onchange = () => resolve(takeUp(app, input.files[0]));
      input.oncancel = () => resolve([]);
    });
    input.click();
    return done;
  }

  async function takeUp(app, file) {
    const bytes = new Uint8Array(await file.arrayBuffer());
    const files = file.name.endsWith(".zip") ? await unzipped(bytes) : { [file.name]: bytes };
    const { contents } = app.serviceManager;
    for (const [path, data] of Object.entries(files)) {
      await folders(contents, path);
      await contents.save(path, model(path, new TextDecoder().decode(data)));
    }
    for (const widget of app.shell.widgets("main")) if (widget.context?.path in files) await widget.context.revert();
    return Object.keys(files);
  }

  function model(path, text) {
    if (path.endsWith(".ipynb")) return { type: "notebook", format: "json", content: JSON.parse(text) };
    return { type: "file", format: "text", content: text };
  }

  async function folders(contents, path) {
    const parts = path.split("/").slice(0, -1);
    for (let i = 1; i <= parts.length; i++) {
      const folder = parts.slice(0, i).join("/");
      await contents.get(folder, { content: false }).catch(() => contents.save(folder, { type: "directory" }));
    }
  }

  // ---- zip files: written without compression, read with or without ----

  const CRC = Uint32Array.from({ length: 256 }, (_, n) => {
    for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
    return n >>> 0;
  });

  function crc32(data) {
    let c = ~0;
    for (const byte of data) c = CRC[(c ^ byte) & 255] ^ (c >>> 8);
    return ~c >>> 0;
  }

  // Little-endian numbers: [bytes, value] each.
  function record(...fields) {
    const view = new DataView(new ArrayBuffer(fields.reduce((sum, [size]) => sum + size, 0)));
    let at = 0;
    for (const [size, value] of fields) {
      if (size === 2) view.setUint16(at, value, true);
      else view.setUint32(at, value, true);
      at += size;
    }
    return new Uint8Array(view.buffer);
  }

  const UTF8 = 0x0800, DAY = 0x5821; // names are in UTF-8; a day, for there must be one

  function zip(files) {
    const parts = [], directory = [];
    let at = 0;
    for (const [name, data] of Object.entries(files)) {
      const bytes = new TextEncoder().encode(name), n = data.length;
      const about = [[2, 20], [2, UTF8], [2, 0], [2, 0], [2, DAY], [4, crc32(data)], [4, n], [4, n], [2, bytes.length]];
      const local = record([4, 0x04034b50], ...about, [2, 0]);
      directory.push(record([4, 0x02014b50], [2, 20], ...about, [2, 0], [2, 0], [2, 0], [2, 0], [4, 0], [4, at]), bytes);
      parts.push(local, bytes, data);
      at += local.length + bytes.length + n;
    }
    const size = directory.reduce((sum, part) => sum + part.length, 0), count = Object.keys(files).length;
    const end = record([4, 0x06054b50], [2, 0], [2, 0], [2, count], [2, count], [4, size], [4, at], [2, 0]);
    return new Blob([...parts, ...directory, end]);
  }

  async function unzipped(bytes) {
    const view = new DataView(bytes.buffer), u16 = at => view.getUint16(at, true), u32 = at => view.getUint32(at, true);
    let end = bytes.length - 22;
    while (end >= 0 && u32(end) !== 0x06054b50) end--;
    if (end < 0) throw new Error("this is not a zip file");
    const files = {};
    for (let i = 0, at = u32(end + 16); i < u16(end + 10); i++) {
      const name = new TextDecoder().decode(bytes.subarray(at + 46, at + 46 + u16(at + 28)));
      const [method, packed, start] = [u16(at + 10), u32(at + 20), u32(at + 42)];
      at += 46 + u16(at + 28) + u16(at + 30) + u16(at + 32);
      if (name.endsWith("/")) continue;
      if (/^\/|\\|(^|\/)\.\.(\/|$)/.test(name)) throw new Error(`the zip file has a name that leads out: ${name}`);
      const from = start + 30 + u16(start + 26) + u16(start + 28), data = bytes.subarray(from, from + packed);
      files[name] = method === 0 ? data : await inflated(data);
    }
    return files;
  }

  async function inflated(data) {
    const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  window._JUPYTERLAB = window._JUPYTERLAB || {};
  window._JUPYTERLAB[NAME] = { init: given => void (scope = given), get };
})();
