"use strict";
// The before/after slider takes its images from the strip below it, so that each is in the file once.
for (const compare of document.querySelectorAll(".compare")) {
  const images = compare.parentElement.querySelectorAll(".strip img");
  const stage = compare.querySelector(".stage");
  const range = stage.querySelector("input");
  const sides = ["left", "right"].map((side) => ({
    select: compare.querySelector(`.${side}-choice`),
    image: compare.querySelector(`.${side}-image`),
    first: Number(compare.dataset[side]),
  }));
  for (const { select, image, first } of sides) {
    for (const source of images) select.add(new Option(source.alt));
    const show = () => {
      image.src = images[select.selectedIndex].src;
      image.alt = images[select.selectedIndex].alt;
    };
    select.selectedIndex = first;
    select.addEventListener("change", show);
    show();
  }
  range.addEventListener("input", () => stage.style.setProperty("--split", `${range.value}%`));
  compare.hidden = false;
}

// Each pipeline can be taken out of all plots of the page.
for (const button of document.querySelectorAll(".legend button")) {
  button.addEventListener("click", () => {
    const shown = button.getAttribute("aria-pressed") !== "true";
    for (const other of document.querySelectorAll(`.legend button[data-style="${button.dataset.style}"]`))
      other.setAttribute("aria-pressed", String(shown));
    for (const shape of document.querySelectorAll(`.plots svg .${button.dataset.style}`))
      shape.classList.toggle("off", !shown);
  });
}
