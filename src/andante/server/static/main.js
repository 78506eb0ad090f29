// The page: what the server knows, shown step by step.

import { boxBeside, isShown, place, rectangleOf, relationBetween, windowAround, windowClose } from "./geometry.js";
import * as server from "./server.js";
import { Surface } from "./surface.js";
import { Tile, element } from "./tiles.js";

const VIEW_DEGREES = 140;
const TILE_DEGREES = 110;
const COLOURS = 6; // .colour-0 to .colour-5 in style.css
const POLL_MS = 250;
const NUMBERS = ["right", "up", "width", "height"];

const $ = (id) => document.getElementById(id);

let known = null; // the server's state
let wish = null; // a step that only this page knows of: "choose" or "check"
let relation = null; // of the box that is being drawn, in units of the anchor's box
let at = 0; // which of the anchor's frames is drawn in
let shownAnchor = ""; // what the drawing step was set up for
let previews = []; // {tile, frame}
const leftOut = new Map(); // name of a landmark -> Set of frames of its sheet, each with those around it

const surface = new Surface($("surface"), (box) => {
  setRelation(box && relationBetween(frame(), box));
}, () => $("name").focus());

const nextColour = () => known.landmarks.length % COLOURS;
const frame = () => known.anchor.frames[at];
const step = () => (wish && known.phase !== "saved" && known.phase !== "search" ? wish : known.phase);

// Asking the server

async function tell(question) {
  complain("");
  try {
    learn(await question);
    return true;
  } catch (error) {
    complain(error.message);
    return false;
  }
}

function learn(state) {
  const before = known && step();
  known = state;
  if (state.phase === "search") setTimeout(poll, POLL_MS);
  if (state.problem) complain(state.problem);
  if (state.problem?.startsWith("two things")) $("which").open = true;
  render(before);
}

async function poll() {
  try {
    learn(await server.state());
  } catch (error) {
    complain(error.message);
    setTimeout(poll, 4 * POLL_MS);
  }
}

function complain(words) {
  $("problem").textContent = words && words[0].toUpperCase() + words.slice(1);
  $("problem").hidden = !words;
}

const say = (words) => { $("status").textContent = words; };

function go(next) {
  const before = step();
  wish = next;
  complain("");
  render(before);
}

// Showing

function render(before) {
  const now = step();
  $("recording").textContent = `${known.recording.name} · ${known.recording.frames} frames`;
  for (const section of document.querySelectorAll("main > section")) section.hidden = section.id !== now;
  for (const item of document.querySelectorAll(".steps li")) {
    const current = item.dataset.step === (now === "search" ? "choose" : now);
    if (current) item.setAttribute("aria-current", "step");
    else item.removeAttribute("aria-current");
  }
  ({ choose: renderChoose, search: renderSearch, draw: renderDraw, check: renderCheck, saved: renderSaved })[now]();
  if (before && before !== now) {
    window.scrollTo(0, 0);
    $(`${now}-title`).focus({ preventScroll: true });
  }
}

function renderChoose() {
  $("choose-back").hidden = known.phase !== "draw";
  if ($("kinds").childElementCount) return;
  for (const kind of known.suggested) {
    const radio = element("input", { type: "radio", name: "kind", value: kind });
    radio.checked = kind === (known.kind ?? known.suggested[0]);
    radio.addEventListener("change", () => { $("other-kind").value = ""; });
    $("kinds").append(element("label", {}, radio, element("span", {}, kind)));
  }
  const others = known.kinds.filter((kind) => !known.suggested.includes(kind));
  $("other-row").hidden = !others.length;
  $("other-kind").append(...others.map((kind) => element("option", { value: kind }, kind)));
}

function renderSearch() {
  const { done, total } = known.progress;
  $("search-title").textContent = `Looking for the ${known.kind}`;
  $("search-bar").max = total || 1;
  $("search-bar").value = done;
  $("search-count").textContent = total ? `${done} of ${total} frames` : "";
}

function renderDraw() {
  if (shownAnchor !== anchorKey()) setUpDrawing();
  renderFrame();
  renderTaught();
}

const anchorKey = () => `${known.anchor.name} ${known.anchor.frames.map((one) => one.index).join()}`;

function setUpDrawing() {
  shownAnchor = anchorKey();
  const { name, best, frames } = known.anchor;
  at = frames.findIndex((one) => one.index === best);
  relation = null;
  $("anchor-tag").textContent = name;
  $("frame").max = frames.length - 1;
  const wanted = new Set(known.anchor.previews);
  previews = frames.filter((one) => wanted.has(one.index)).map((one) => {
    const tile = new Tile(one.index, windowAround(one, TILE_DEGREES, known.view), known.view, `frame ${one.index}`);
    tile.mark("the anchor", one, "anchor");
    tile.figure.setAttribute("role", "listitem");
    return { tile, frame: one };
  });
  $("previews").replaceChildren(...previews.map((one) => one.tile.figure));
  setRelation(null);
}

function renderFrame() {
  const here = frame();
  const window = windowAround(here, VIEW_DEGREES, known.view);
  const url = server.pictureUrl(here.index, window);
  if (!$("view").src.endsWith(url)) $("view").src = url;
  $("view").alt = `Frame ${here.index} around the ${known.anchor.name}`;
  place($("anchor-box"), rectangleOf(here, window));
  surface.show(window, here, relation && boxBeside(here, relation));
  $("surface").querySelectorAll(".taught").forEach((one) => one.remove());
  for (const { box, kind } of taughtBoxes(here)) {
    const mark = element("div", { className: `box ${kind}` });
    place(mark, rectangleOf(box, window));
    $("anchor-box").before(mark);
  }
  $("frame").value = at;
  const how = here.followed ? "followed from other frames" : `found, score ${(here.score ?? 0).toFixed(2)}`;
  const words = `frame ${here.index} · ${here.time_s.toFixed(1)} s · ${how}`;
  $("frame-words").textContent = words;
  $("frame").setAttribute("aria-valuetext", words);
}

// Boxes of what was taught by this anchor, in a frame.
function taughtBoxes(one) {
  const own = [...known.landmarks.entries()].filter(([, other]) => other.anchor === known.anchor.name);
  return own.map(([number, other]) => ({ box: boxBeside(one, other), kind: `taught colour-${number % COLOURS}` }));
}

function setRelation(next) {
  relation = next;
  for (const key of NUMBERS) if (document.activeElement !== $(key)) $(key).value = next ? next[key].toFixed(2) : "";
  for (const { tile, frame: one } of previews) {
    const box = next && boxBeside(one, next);
    tile.mark("the landmark", box, `landmark colour-${nextColour()}`);
    tile.figure.classList.toggle("outside", Boolean(box) && !isShown(box, known.view));
  }
  const frames = known.anchor.frames;
  const count = next ? frames.filter((one) => isShown(boxBeside(one, next), known.view)).length : 0;
  $("fit").textContent = next ? `In the picture in ${count} of ${frames.length} frames with the ${known.anchor.name}.`
    : "Draw a box first.";
  $("fit").classList.toggle("warn", Boolean(next) && count < frames.length / 2);
  $("add").disabled = !next;
  $("box-words").textContent = next ? `${next.right.toFixed(1)} to the right, ${next.up.toFixed(1)} up, `
    + `${next.width.toFixed(1)} wide, ${next.height.toFixed(1)} high, in sizes of the ${known.anchor.name}` : "no box";
}

function renderTaught() {
  const { landmarks } = known;
  $("taught").hidden = !landmarks.length;
  $("taught-list").replaceChildren(...landmarks.map((one, number) => {
    const remove = element("button", { type: "button", className: "plain", ariaLabel: `Remove ${one.name}` }, "Remove");
    remove.addEventListener("click", () => tell(server.remove(one.name)));
    return element("li", {}, element("span", { className: `dot colour-${number % COLOURS}` }),
      element("span", { className: "grow" }, one.name, element("small", {}, `${one.frames} frames, by the ${one.anchor}`)),
      remove);
  }));
  $("landmark-box").className = `box landmark colour-${nextColour()}`;
  for (const { tile, frame: one } of previews) tile.setMarks(taughtBoxes(one));
}

// What is wrong in a frame of the sheet is wrong in those next to it, which the sheet does not show.
function framesLeftOut(landmark) {
  const frames = leftOut.get(landmark.name) ?? new Set();
  return landmark.sheet.filter((one) => frames.has(one.index)).flatMap((one) => one.around);
}

function renderCheck() {
  $("sheets").replaceChildren(...known.landmarks.map((one, number) => {
    if (!leftOut.has(one.name)) leftOut.set(one.name, new Set());
    const count = element("span", { className: "soft" });
    const tell = () => {
      const left = framesLeftOut(one).length;
      count.textContent = `${one.frames - left} labels${left ? `, ${left} left out` : ""}`;
    };
    tell();
    const tiles = one.sheet.map((box) => sheetTile(one, box, number, tell));
    const title = element("h3", {}, element("span", { className: `dot colour-${number % COLOURS}` }), one.name, " ", count);
    return element("div", {}, title, element("div", { className: "tiles" }, ...tiles));
  }));
}

function sheetTile(landmark, box, number, changed) {
  const tile = new Tile(box.index, windowClose(box, TILE_DEGREES, known.view), known.view, `frame ${box.index}`);
  tile.mark("it", box, `taught colour-${number % COLOURS}`);
  const frames = leftOut.get(landmark.name);
  const button = element("button", { type: "button", className: "choice" }, tile.figure);
  const show = () => {
    button.setAttribute("aria-pressed", String(frames.has(box.index)));
    tile.caption.textContent = `frame ${box.index}${frames.has(box.index) ? " · left out" : ""}`;
    button.setAttribute("aria-label", `Leave out frame ${box.index} of ${landmark.name} and those around it`);
  };
  button.addEventListener("click", () => {
    if (!frames.delete(box.index)) frames.add(box.index);
    show();
    changed();
  });
  show();
  return button;
}

function renderSaved() {
  const { folder, files, next } = known.saved;
  $("saved-words").textContent = `${known.landmarks.length === 1 ? "One landmark" : `${known.landmarks.length} landmarks`} in ${folder}`;
  $("saved-files").replaceChildren(...files.map((name) => element("li", {}, name)));
  $("saved-next").textContent = next;
}

// Acting

$("choose-form").addEventListener("submit", (event) => {
  event.preventDefault();
  const kind = $("other-kind").value || new FormData(event.target).get("kind");
  const which = { frame: $("which-frame").valueAsNumber, azimuth_deg: $("which-degrees").valueAsNumber };
  wish = null;
  tell(server.search(kind, Object.values(which).every(Number.isFinite) ? which : {}));
});
$("other-kind").addEventListener("change", () => {
  const chosen = document.querySelector("#kinds input:checked");
  if (chosen) chosen.checked = !$("other-kind").value;
});
$("choose-back").addEventListener("click", () => go(null));
$("search-stop").addEventListener("click", () => tell(server.stopSearch()));
$("other-anchor").addEventListener("click", () => go("choose"));
$("to-check").addEventListener("click", () => go("check"));
$("check-back").addEventListener("click", () => go(null));

function moveTo(next) {
  at = Math.min(known.anchor.frames.length - 1, Math.max(0, next));
  renderFrame();
}
$("frame").addEventListener("input", () => moveTo(Number($("frame").value)));
$("earlier").addEventListener("click", () => moveTo(at - 1));
$("later").addEventListener("click", () => moveTo(at + 1));

for (const key of NUMBERS) {
  $(key).addEventListener("input", () => {
    const values = Object.fromEntries(NUMBERS.map((one) => [one, Number.parseFloat($(one).value)]));
    const usable = NUMBERS.every((one) => Number.isFinite(values[one])) && values.width > 0 && values.height > 0;
    if (!usable) return;
    setRelation(values);
    surface.set(boxBeside(frame(), values));
  });
}

$("name-form").addEventListener("submit", async (event) => {
  event.preventDefault();
  if (!relation) return;
  const name = $("name").value.trim();
  if (!name) {
    complain("give the landmark a name first");
    $("name").focus();
    return;
  }
  if (await tell(server.draw(name, relation))) {
    $("name").value = "";
    setRelation(null);
    surface.set(null);
    say(`${name} added. Draw another landmark, or check and save.`);
    $("to-check").focus({ preventScroll: true });
  }
});

$("save").addEventListener("click", async () => {
  $("save").disabled = true;
  $("save").textContent = "Saving …";
  say("Saving. Pictures of many frames take a while.");
  const chosen = known.landmarks.map((one) => ({ landmark: one.name, frames: framesLeftOut(one) }));
  wish = null;
  const done = await tell(server.save(chosen.filter((one) => one.frames.length)));
  $("save").disabled = false;
  $("save").textContent = "Approve and save";
  say("");
  if (!done) wish = "check";
});

tell(server.state());
