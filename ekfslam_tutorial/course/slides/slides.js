// Slides: arrow keys, Page Up and Down, Home and End, or a click at the right or left edge.
// Loaded at the end of the page, after MathJax.
"use strict";
const deck = document.getElementById("deck");
const slides = [...deck.children];
const number = document.querySelector("nav");
const LEAST_PX = 20; // the smallest letters that are read from the last row

function show(n) {
  n = Math.max(0, Math.min(slides.length - 1, n));
  slides.forEach((slide, i) => {
    slide.classList.toggle("now", i === n);
    slide.inert = i !== n; // no focus on a slide that is not shown
  });
  number.textContent = `${n + 1} / ${slides.length}`;
  history.replaceState(null, "", `#${n + 1}`);
}

function now() {
  return slides.findIndex((slide) => slide.classList.contains("now"));
}

function scale() {
  const k = Math.min(innerWidth / 1280, innerHeight / 720);
  deck.style.transform = `translate(${(innerWidth - 1280 * k) / 2}px, ${(innerHeight - 720 * k) / 2}px) scale(${k})`;
}

// Formulas that are too wide shrink alone, all of a slide alike; then all letters, until the slide is not too high.
function fit(slide) {
  const main = slide.querySelector("main");
  const formulas = [...slide.querySelectorAll('mjx-container[display="true"]')];
  const widest = Math.max(0, ...formulas.map((formula) => formula.firstElementChild.getBoundingClientRect().width));
  const k = main.getBoundingClientRect().width / widest; // both as scaled to the window
  if (k < 1) for (const formula of formulas) formula.style.fontSize = `${Math.floor(96 * k)}%`;
  for (let px = 30; px >= LEAST_PX && main.scrollHeight > main.clientHeight; px--)
    slide.style.setProperty("--fit", `${px}px`);
}

const STEPS = { ArrowRight: 1, ArrowDown: 1, PageDown: 1, " ": 1, ArrowLeft: -1, ArrowUp: -1, PageUp: -1 };
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("summary, .page, input")) return;
  if (event.key === "Home") show(0);
  else if (event.key === "End") show(slides.length - 1);
  else if (event.key in STEPS) show(now() + STEPS[event.key]);
  else return;
  event.preventDefault();
});
addEventListener("click", (event) => {
  if (event.target.closest("details, .page, a")) return;
  if (event.clientX > innerWidth * 0.93) show(now() + 1);
  if (event.clientX < innerWidth * 0.07) show(now() - 1);
});
addEventListener("hashchange", () => show(Number(location.hash.slice(1)) - 1));
addEventListener("resize", scale);

scale();
show((Number(location.hash.slice(1)) || 1) - 1);
MathJax.startup.promise.then(() => {
  slides.forEach(fit);
  document.body.dataset.ready = "yes";
});
