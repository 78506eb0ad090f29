// Small pictures with boxes on them.

import { place, rectangleOf } from "./geometry.js";
import { pictureUrl } from "./server.js";

const HEIGHT_PX = 240; // of the picture that is fetched; shown at about half of it, for sharp screens

export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in made && key !== "role") made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

// A picture of one frame in a window; `view` is what the frame shows at all, in height. `mark` puts a box on it that has a name, or takes it away for null;
// `setMarks` puts any number of others in place of those that it put there before.
export class Tile {
  constructor(index, window, view, caption) {
    this.window = window;
    this.marks = new Map();
    this.others = [];
    this.caption = element("figcaption", {}, caption);
    // Pictures come at full height: what the window does not show of it lies outside.
    const times = (view.max_rad - view.min_rad) / (window.high - window.low);
    const image = element("img", {
      src: pictureUrl(index, window, Math.round(times * HEIGHT_PX)), alt: "", loading: "lazy", decoding: "async",
      draggable: false,
    });
    image.style.height = `${100 * times}%`;
    image.style.top = `${(-100 * (view.max_rad - window.high)) / (window.high - window.low)}%`;
    this.picture = element("div", { className: "picture" }, image);
    this.picture.style.aspectRatio = `${window.width} / ${window.high - window.low}`;
    this.figure = element("figure", { className: "tile" }, this.picture, this.caption);
  }

  mark(name, box, kind) {
    let mark = this.marks.get(name);
    if (!mark) {
      mark = element("div", { className: "box" });
      this.marks.set(name, mark);
      this.picture.append(mark);
    }
    mark.className = `box ${kind}`;
    mark.hidden = box === null;
    if (box) place(mark, rectangleOf(box, this.window));
  }

  setMarks(boxes) {
    for (const other of this.others) other.remove();
    this.others = boxes.map(({ box, kind }) => {
      const mark = element("div", { className: `box ${kind}` });
      place(mark, rectangleOf(box, this.window));
      return mark;
    });
    this.picture.append(...this.others);
  }
}
