// The picture that a person draws in: one box, by mouse, finger or keyboard.

import { degrees, boxOf, place, rectangleOf } from "./geometry.js";

const SMALLEST = 0.008; // of the picture's width: a click is no box
const STEP = degrees(1);
const FINE_STEP = degrees(0.2);
const MOVES = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class Surface {
  // onChange(box or null) is called whenever the person changes the box, onDone when Enter is pressed.
  constructor(element, onChange, onDone) {
    this.element = element;
    this.mark = element.querySelector(".landmark");
    this.onChange = onChange;
    this.onDone = onDone;
    this.drag = null;
    element.addEventListener("pointerdown", (event) => this.begin(event));
    element.addEventListener("pointermove", (event) => this.move(event));
    element.addEventListener("pointerup", (event) => this.end(event));
    element.addEventListener("pointercancel", (event) => this.end(event));
    element.addEventListener("keydown", (event) => this.key(event));
  }

  // A picture of a window of the horizon, with an anchor in it, and the landmark's box or null.
  show(window, anchor, box) {
    this.window = window;
    this.anchor = anchor;
    this.element.style.aspectRatio = `${window.width} / ${window.high - window.low}`;
    this.set(box);
  }

  set(box) {
    this.box = box;
    this.mark.hidden = box === null;
    if (box) place(this.mark, rectangleOf(box, this.window));
  }

  change(box) {
    this.set(box);
    this.onChange(box);
  }

  point(event) {
    const area = this.element.getBoundingClientRect();
    const within = (share) => Math.min(1, Math.max(0, share));
    return { x: within((event.clientX - area.left) / area.width), y: within((event.clientY - area.top) / area.height) };
  }

  begin(event) {
    if (!this.window || event.button !== 0 || this.drag) return;
    const start = this.point(event);
    const corner = event.target.dataset.corner;
    const old = this.box && rectangleOf(this.box, this.window);
    if (corner) {
      // The opposite corner stays where it is.
      this.drag = {
        kind: "corners",
        x: corner.includes("w") ? old.left + old.width : old.left,
        y: corner.includes("n") ? old.top + old.height : old.top,
      };
    } else if (event.target === this.mark) {
      this.drag = { kind: "whole", x: start.x - old.left, y: start.y - old.top, old };
    } else {
      this.drag = { kind: "corners", x: start.x, y: start.y };
    }
    this.drag.pointer = event.pointerId;
    this.element.setPointerCapture(event.pointerId);
    this.element.focus({ preventScroll: true });
    event.preventDefault();
  }

  move(event) {
    if (!this.drag || event.pointerId !== this.drag.pointer) return;
    const at = this.point(event);
    const { kind, x, y, old } = this.drag;
    if (kind === "whole") {
      this.change(boxOf({ ...old, left: at.x - x, top: at.y - y }, this.window));
      return;
    }
    const rectangle = {
      left: Math.min(x, at.x), top: Math.min(y, at.y), width: Math.abs(at.x - x), height: Math.abs(at.y - y),
    };
    if (rectangle.width > SMALLEST && rectangle.height > SMALLEST) this.change(boxOf(rectangle, this.window));
  }

  end(event) {
    if (this.drag && event.pointerId === this.drag.pointer) this.drag = null;
  }

  key(event) {
    if (!this.window || event.ctrlKey || event.metaKey) return;
    if (event.key === "Enter") {
      this.onDone();
    } else if (event.key === "Escape") {
      this.change(null);
    } else if (event.key in MOVES) {
      this.change(this.box === null ? this.above() : this.stepped(event));
    } else {
      return;
    }
    event.preventDefault();
  }

  // Where a box begins that was not drawn: above the anchor, as large.
  above() {
    return { ...this.anchor, elevation: this.anchor.elevation + 1.2 * this.anchor.height };
  }

  stepped(event) {
    const [left, up] = MOVES[event.key];
    const step = event.altKey ? FINE_STEP : STEP;
    const box = { ...this.box };
    if (event.shiftKey) {
      box.width = Math.max(STEP, box.width - 2 * left * step);
      box.height = Math.max(STEP, box.height + 2 * up * step);
    } else {
      box.azimuth += left * step;
      box.elevation += up * step;
    }
    return box;
  }
}
