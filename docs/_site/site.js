// A table that scrolls sideways must be within reach of the keyboard.
addEventListener("DOMContentLoaded", () => {
  for (const box of document.querySelectorAll(".bd-article table, .bd-article div.cell_output")) box.tabIndex = 0;
  for (const fold of document.querySelectorAll(".bd-links summary")) fold.ariaLabel = "Pages of this part";
});
