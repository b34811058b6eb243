// JupyterLite's own program, through which Python reaches the student's files. It would carry every file of the site,
// too, only to hand it on: these come straight from the browser, which keeps what it has compiled of them.
addEventListener("fetch", event => {
  if (!new URL(event.request.url).pathname.includes("/api/")) event.stopImmediatePropagation();
});
importScripts("service-worker-of-jupyterlite.js");
