// Boxes on the horizon circle, in radians: azimuth counter-clockwise from forward, so to the left in a picture.
// A window is the part of the panorama that a picture shows: azimuth of its middle, width, lowest and highest elevation.

const DEGREE = Math.PI / 180;
const VISIBLE_SHARE = 0.5; // as andante.landmarks.teaching
const WIDEST = Math.PI;
const CLOSEST = 0.3; // share of the whole window
const AROUND = 2.5; // times a box fits into a close window

export const degrees = (count) => count * DEGREE;

export function wrapped(angle) {
  return angle - 2 * Math.PI * Math.floor((angle + Math.PI) / (2 * Math.PI));
}

export function windowAround(box, widthDegrees, view) {
  return { azimuth: box.azimuth, width: widthDegrees * DEGREE, low: view.min_rad, high: view.max_rad };
}

// A narrower window of the same shape where a box is small, so that it can be judged; within the picture.
export function windowClose(box, widestDegrees, view) {
  const tall = view.max_rad - view.min_rad;
  const share = Math.min(1, Math.max(CLOSEST, (AROUND * box.width) / degrees(widestDegrees), (AROUND * box.height) / tall));
  const low = Math.min(view.max_rad - share * tall, Math.max(view.min_rad, box.elevation - (share * tall) / 2));
  return { azimuth: box.azimuth, width: share * degrees(widestDegrees), low, high: low + share * tall };
}

export function boxBeside(anchor, relation) {
  return {
    azimuth: wrapped(anchor.azimuth - relation.right * anchor.width),
    elevation: anchor.elevation + relation.up * anchor.height,
    width: relation.width * anchor.width,
    height: relation.height * anchor.height,
  };
}

export function relationBetween(anchor, box) {
  return {
    right: wrapped(anchor.azimuth - box.azimuth) / anchor.width,
    up: (box.elevation - anchor.elevation) / anchor.height,
    width: box.width / anchor.width,
    height: box.height / anchor.height,
  };
}

// A rectangle is a box in shares of a picture: left, top, width, height from 0 to 1.
export function rectangleOf(box, window) {
  const middle = 0.5 + wrapped(window.azimuth - box.azimuth) / window.width;
  const tall = window.high - window.low;
  return {
    left: middle - box.width / window.width / 2,
    top: (window.high - box.elevation - box.height / 2) / tall,
    width: box.width / window.width,
    height: box.height / tall,
  };
}

export function boxOf(rectangle, window) {
  const tall = window.high - window.low;
  return {
    azimuth: wrapped(window.azimuth - (rectangle.left + rectangle.width / 2 - 0.5) * window.width),
    elevation: window.high - (rectangle.top + rectangle.height / 2) * tall,
    width: rectangle.width * window.width,
    height: rectangle.height * tall,
  };
}

// Whether a box would become a label: at least half of it between the lowest and the highest row.
export function isShown(box, view) {
  const high = Math.min(box.elevation + box.height / 2, view.max_rad);
  const low = Math.max(box.elevation - box.height / 2, view.min_rad);
  return box.width <= WIDEST && (high - low) / box.height >= VISIBLE_SHARE;
}

export function place(element, rectangle) {
  for (const [side, key] of [["left", "left"], ["top", "top"], ["width", "width"], ["height", "height"]]) {
    element.style[side] = `${100 * rectangle[key]}%`;
  }
}
