"use strict";
// The before/after slider takes its images from the strip below it, so that each is in the file once.
const comparisons = new Map();
for (const compare of document.querySelectorAll(".compare")) {
  const images = compare.parentElement.querySelectorAll(".strip img");
  const stage = compare.querySelector(".stage"), zoom = compare.querySelector(".zoom-choice");
  const link = compare.querySelector(".crop-link");
  const range = stage.querySelector("input");
  const sides = ["left", "right"].map((side) => ({
    select: compare.querySelector(`.${side}-choice`),
    image: compare.querySelector(`.${side}-image`),
    first: Number(compare.dataset[side]),
  }));
  const middle = { x: 0.5, y: 0.5 }; // of what is seen, in shares of the picture
  // A picture grows around its origin; the one that brings the middle to the middle, or as near as the picture's border lets it.
  const origin = (at) => {
    const seen = 1 / Number(zoom.value);
    return seen < 1 ? Math.min(Math.max((at - seen / 2) / (1 - seen), 0), 1) : 0.5;
  };
  const show = () => {
    for (const { select, image } of sides) {
      image.src = images[select.selectedIndex].src;
      image.alt = images[select.selectedIndex].alt;
    }
    stage.style.setProperty("--zoom", zoom.value);
    stage.style.setProperty("--x", `${100 * origin(middle.x)}%`);
    stage.style.setProperty("--y", `${100 * origin(middle.y)}%`);
    const words = [compare.dataset.shot, ...sides.map(({ image }) => image.alt), middle.x.toFixed(4), middle.y.toFixed(4), zoom.value];
    link.href = `#crop/${words.map(encodeURIComponent).join("/")}`;
  };
  for (const { select, first } of sides) {
    for (const source of images) select.add(new Option(source.alt));
    select.selectedIndex = first;
    select.addEventListener("change", show);
  }
  zoom.addEventListener("change", show);
  range.addEventListener("input", () => stage.style.setProperty("--split", `${range.value}%`));
  range.addEventListener("dblclick", (event) => {
    const box = stage.getBoundingClientRect(), seen = 1 / Number(zoom.value);
    middle.x = origin(middle.x) * (1 - seen) + ((event.clientX - box.left) / box.width) * seen;
    middle.y = origin(middle.y) * (1 - seen) + ((event.clientY - box.top) / box.height) * seen;
    zoom.selectedIndex = (zoom.selectedIndex + 1) % zoom.options.length;
    show();
  });
  comparisons.set(compare.dataset.shot, (left, right, x, y, times) => {
    const names = Array.from(images, (image) => image.alt);
    const wanted = [names.indexOf(left), names.indexOf(right)], sizes = Array.from(zoom.options, (o) => o.value);
    if (wanted.includes(-1) || !sizes.includes(times) || !(x >= 0 && x <= 1 && y >= 0 && y <= 1)) return;
    sides.forEach(({ select }, side) => (select.selectedIndex = wanted[side]));
    Object.assign(middle, { x: Number(x), y: Number(y) });
    zoom.value = times;
    show();
    compare.scrollIntoView({ block: "start" });
  });
  compare.hidden = false;
  show();
}

// An address with #crop/SHOT/LEFT/RIGHT/X/Y/ZOOM opens at this crop.
const open_crop = () => {
  if (!location.hash.startsWith("#crop/")) return;
  try {
    const [, shot, ...words] = location.hash.split("/").map(decodeURIComponent);
    comparisons.get(shot)?.(...words);
  } catch (mangled) {
    if (!(mangled instanceof URIError)) throw mangled;
  }
};
addEventListener("hashchange", open_crop);
open_crop();

// Who asked for less motion starts it himself.
if (matchMedia("(prefers-reduced-motion: reduce)").matches)
  for (const motion of document.querySelectorAll("details.motion")) motion.open = false;

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
