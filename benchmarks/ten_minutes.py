"""Two landmarks from nothing to ``andante evaluate`` as a user does it, timed step by step.

    python benchmarks/ten_minutes.py --weights yolox_nano.onnx [--seed 11] [--out .bench/ten_minutes] [--workers 2]

Renders a garden of that seed once (extras sim, landmarks, torch, onnx, and playwright with Chromium): ``teach``, a
drive in lanes over the lawn while a bicycle leans at one landmark and a person stands before another, and ``later``
and ``autumn``, random drives without them in other light. Then it starts ``andante teach``, uses its page by mouse and
keyboard, and runs ``learn-landmarks``, ``map`` and ``evaluate``. Of the truth it uses the box of each landmark in the
one frame in which that is drawn; what it prints besides compares with the truth afterwards. Pictures of every stage
are in ``--out``.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from playwright.sync_api import Page, expect, sync_playwright

from andante.angles import wrapped
from andante.landmarks.boxes import Box
from andante.landmarks.detector import LandmarkDetector
from andante.landmarks.labels import Labels
from andante.landmarks.windows import clipped
from andante.recordings import open_recording
from andante.simulator import (
    Conditions,
    ExtentFinder,
    Garden,
    GardenSpec,
    GivenPoses,
    InfieldRun,
    Placed,
    Plan,
    Session,
    SimulatedCamera,
    SimulatedRecording,
    Thing,
    make_garden,
    render_plan,
)
from andante.simulator.extents import object_number
from andante.simulator.movables import MOVABLES

ANCHORS = "bicycle", "person"
LANDMARKS = "shed", "tree"
TESTS = "later", "autumn"
STEP_M, LANE_M, FROM_BORDER_M, GAP_M = 0.35, 1.4, 1.2, 0.08
VIEW_RAD = math.radians(140.0)  # of the picture that is drawn in, as on the page
SAME_IOU, TALL_RAD, WIDE_RAD = 0.3, math.radians(7.0), math.radians(2.5)
ARGUMENTS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-sync"]


@dataclass(frozen=True)
class Subject:
    """A landmark, what it is called on the page, and the anchor that was put before it."""

    object: str
    name: str
    anchor: Placed


def subjects(garden: Garden) -> list[Subject]:
    """Of each kind the thing inside of the fence that is farthest from those chosen before, an anchor before each."""
    counts: dict[str, int] = {}
    inside: dict[str, list[tuple[str, Thing]]] = {kind: [] for kind in LANDMARKS}
    for thing in garden.things:
        counts[thing.kind] = counts.get(thing.kind, 0) + 1
        if thing.kind in inside and np.abs(place(thing)).max() < garden.spec.size_x_m / 2.0:
            inside[thing.kind].append((f"{thing.kind}{counts[thing.kind]}", thing))
    chosen: list[tuple[str, Thing]] = []
    for kind in LANDMARKS:
        if not inside[kind]:
            raise SystemExit(f"this garden has no {kind} inside of its fence; take another --seed")

        def apart(one: tuple[str, Thing]) -> float:
            return min((float(np.linalg.norm(place(one[1]) - place(other[1]))) for other in chosen), default=0.0)

        chosen.append(max(inside[kind], key=apart))
    return [
        Subject(name, kind, before(thing, anchor))
        for (name, thing), kind, anchor in zip(chosen, LANDMARKS, ANCHORS, strict=True)
    ]


def place(thing: Thing) -> np.ndarray:
    return np.array([thing.footprints[0].x_m, thing.footprints[0].y_m])


def before(thing: Thing, kind: Any) -> Placed:
    """Directly before a thing on the side of the lawn, its long side along the wall."""
    inward = -place(thing) / np.linalg.norm(place(thing))
    along, across = MOVABLES[kind].size_m
    x, y = place(thing) + inward * (thing.footprints[0].half_y_m + min(along, across) / 2.0 + GAP_M)
    turn = math.atan2(inward[1], inward[0]) + (math.pi / 2.0 if along > across else 0.0)
    return Placed(kind=kind, x_m=float(x), y_m=float(y), heading_rad=turn)


def lanes(garden: Garden) -> GivenPoses:
    """To and fro over the lawn with half circles between, as a mower drives."""
    low = garden.border.points_m.min(axis=0) + FROM_BORDER_M
    high = garden.border.points_m.max(axis=0) - FROM_BORDER_M
    rows = np.linspace(low[1] + LANE_M / 2, high[1] - LANE_M / 2, round((high[1] - low[1]) / LANE_M))
    radius = (rows[1] - rows[0]) / 2.0
    left, right = low[0] + radius, high[0] - radius
    line: list[tuple[float, float]] = []
    for number, y in enumerate(rows):
        side = 1.0 if number % 2 == 0 else -1.0
        line += [(x, y) for x in np.linspace(left, right, 200)[:: int(side)]]
        if number + 1 < len(rows):
            middle = right if side > 0 else left
            turn = np.linspace(-math.pi / 2, math.pi / 2, 40)[1:-1]
            line += [(middle + side * radius * math.cos(a), y + radius + radius * math.sin(a)) for a in turn]
    points = np.array(line)
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    at = np.arange(0.0, way[-1], STEP_M)
    xy = np.stack([np.interp(at, way, points[:, axis]) for axis in (0, 1)], 1)
    ahead = np.gradient(xy, axis=0)
    heading = np.arctan2(ahead[:, 1], ahead[:, 0])
    return GivenPoses(poses=tuple(map(tuple, np.round(np.column_stack([xy, heading]), 5).tolist())))


def plan_of(seed: int, side_px: int) -> tuple[Plan, list[Subject]]:
    spec = GardenSpec(seed=seed, size_x_m=18.0, size_y_m=18.0)
    garden = make_garden(spec)
    chosen = subjects(garden)
    test = InfieldRun(frames=120, rate_hz=2.0)
    sessions = (
        Session(name="teach", seed=100 * seed, drive=lanes(garden), placed=tuple(one.anchor for one in chosen)),
        Session(
            name="later",
            seed=100 * seed + 1,
            drive=test,
            conditions=Conditions(hour=15.5, clouds=0.8, sun_energy=4.0, sun_y_m=-6.0),
        ),
        Session(
            name="autumn",
            seed=100 * seed + 2,
            drive=test,
            conditions=Conditions(season="autumn", hour=13.5, clouds=0.3, sun_energy=5.0),
        ),
    )
    camera = SimulatedCamera(width_px=side_px, height_px=side_px, field_of_view_deg=200.0)
    return Plan(garden=spec, camera=camera, sessions=sessions), chosen


class Clock:
    """Seconds of every step, in order."""

    def __init__(self) -> None:
        self.steps: list[tuple[str, float]] = []

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.steps.append((name, time.perf_counter() - start))
        print(f"{name}: {self.steps[-1][1]:.1f} s", file=sys.stderr, flush=True)

    def print(self) -> None:
        print("| step | seconds |\n|---|---:|")
        for name, seconds in [*self.steps, ("**all**", sum(seconds for _, seconds in self.steps))]:
            print(f"| {name} | {seconds:.0f} |")


def andante(*arguments: str | Path) -> list[str]:
    return [str(Path(sys.executable).parent / "andante"), *map(str, arguments)]


def command(log: Path, *arguments: str | Path) -> dict[str, Any]:
    """Run a command to its end; what it says on stderr goes to a file, its JSON is given."""
    with log.open("w") as stderr:
        done = subprocess.run(
            andante(*arguments, "--json"), stdout=subprocess.PIPE, stderr=stderr, text=True, check=False
        )
    if done.returncode:
        raise SystemExit(f"andante {arguments[0]} failed: {log.read_text()}")
    log.with_suffix(".json").write_text(done.stdout)
    return dict(json.loads(done.stdout))


class Truth:
    """What a session really shows of its things."""

    def __init__(self, plan: Plan, session: str) -> None:
        self.recording = SimulatedRecording(plan, session)
        self._finder = ExtentFinder(plan.camera)

    def boxes(self, index: int, names: Sequence[str]) -> list[Box | None]:
        ids = self.recording.rendering(index).object_id
        extents = [self._finder(ids, object_number(self.recording, name)) for name in names]
        return [None if one is None else Box(*one.box) for one in extents]


class Visitor:
    """A person at the page: chooses, drags, types and looks."""

    def __init__(self, page: Page, out: Path, clock: Clock, truth: Truth) -> None:
        self.page, self.out, self.clock, self.truth = page, out, clock, truth
        self._shots = 0

    def shot(self, name: str) -> None:
        # Lazy pictures load when they are scrolled to; the page lets nobody wait by a script of text.
        self.page.evaluate("document.querySelectorAll('img').forEach(one => { one.loading = 'eager'; })")
        while not self.page.evaluate("[...document.images].every(one => one.complete || !one.offsetParent)"):
            self.page.wait_for_timeout(100)
        self._shots += 1
        self.page.screenshot(path=self.out / f"page-{self._shots:02d}-{name}.png", full_page=True)

    def teach(self, one: Subject) -> None:
        page, kind = self.page, one.anchor.kind
        with self.clock.step(f"page: find the {kind}"):
            page.get_by_role("radio", name=kind, exact=True).check()
            page.get_by_role("button", name="Find it").click()
            expect(page.locator("#draw, #problem").filter(visible=True).first).to_be_visible(timeout=600_000)
        if page.get_by_role("alert").is_visible():
            raise SystemExit(page.get_by_role("alert").inner_text())
        self.shot(f"{kind}-found")
        corners = self.seen(one.object)
        with self.clock.step(f"page: draw and name the {one.name}"):
            self.drag(corners)
            page.get_by_label("Name of the landmark").fill(one.name)
        print(f"{one.name}: {page.locator('#fit').inner_text()}", file=sys.stderr)
        self.shot(f"{one.name}-drawn")
        with self.clock.step(f"page: add the {one.name}"):
            page.get_by_role("button", name="Add landmark").click()
            expect(page.locator("#taught-list li").last).to_contain_text(one.name)

    def seen(self, name: str) -> tuple[tuple[float, float], tuple[float, float]]:
        """Corners of a thing in the picture that is drawn in, in shares of it: all that is used of the truth."""
        words = re.match(r"frame (\d+)", self.page.locator("#frame-words").inner_text())
        assert words is not None
        (box,) = self.truth.boxes(int(words[1]), [name])
        state = self.page.evaluate("fetch('/state').then(answer => answer.json())")
        anchor = next(one for one in state["anchor"]["frames"] if one["index"] == int(words[1]))
        assert box is not None
        low, high = state["view"]["min_rad"], state["view"]["max_rad"]
        middle = 0.5 + float(wrapped(anchor["azimuth"] - box.azimuth_rad)) / VIEW_RAD
        half = box.width_rad / VIEW_RAD / 2.0
        corners = np.array(
            [
                [middle - half, (high - box.high_rad) / (high - low)],
                [middle + half, (high - box.low_rad) / (high - low)],
            ]
        )
        first, last = np.clip(corners, 0.002, 0.998).tolist()
        return tuple(first), tuple(last)

    def drag(self, corners: tuple[tuple[float, float], tuple[float, float]]) -> None:
        self.page.locator("#surface").scroll_into_view_if_needed()
        area = self.page.locator("#surface").bounding_box()
        assert area is not None
        first, last = ((area["x"] + x * area["width"], area["y"] + y * area["height"]) for x, y in corners)
        self.page.mouse.move(*first)
        self.page.mouse.down()
        self.page.mouse.move(*last, steps=20)
        self.page.mouse.up()


def taught(folder: Path, weights: Path, chosen: Sequence[Subject], *, clock: Clock, truth: Truth) -> None:
    """``andante teach`` from its start to its end, with somebody at its page."""
    with clock.step("start `andante teach`"):
        process = subprocess.Popen(
            andante("teach", folder, "--weights", weights, "--no-browser"), stderr=subprocess.PIPE, text=True
        )
        assert process.stderr is not None
        address = re.search(r"http://\S+", process.stderr.readline())
    try:
        assert address is not None
        with sync_playwright() as started:
            binary = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
            browser = started.chromium.launch(executable_path=binary, args=ARGUMENTS)
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.set_default_timeout(60_000)
            with clock.step("page: open"):
                page.goto(address[0])
                expect(page.locator("#choose")).to_be_visible()
            visitor = Visitor(page, folder.parent, clock, truth)
            visitor.shot("opened")
            for number, one in enumerate(chosen):
                if number:
                    page.get_by_role("button", name="Use another anchor").click()
                    visitor.shot("another-anchor")
                visitor.teach(one)
            page.get_by_role("button", name="Check and save").click()
            visitor.shot("check")
            with clock.step("page: save"):
                page.get_by_role("button", name="Approve and save").click()
                expect(page.locator("#saved")).to_be_visible(timeout=300_000)
            visitor.shot("saved")
            browser.close()
        process.wait(30)
    finally:
        process.kill()


def labels_right(folder: Path, chosen: Sequence[Subject], truth: Truth) -> None:
    """How the labels compare with what is really seen, in frames spread over them."""
    for one in chosen:
        labels = Labels.load(folder / f"{one.name}.json")
        frames = sorted(labels.boxes)
        shares = []
        for index in (frames[at] for at in np.linspace(0, len(frames) - 1, 24).round().astype(int)):
            (box,) = truth.boxes(index, [one.object])
            shares.append(0.0 if box is None else labels.boxes[index].iou(box))
        worst, middle = np.quantile(shares, [0.1, 0.5])
        print(f"{one.name}: {len(frames)} labels, IoU with the truth {middle:.2f} (median), 10 % below {worst:.2f}")


def detections_right(detector: LandmarkDetector, folder: Path, chosen: Sequence[Subject], truth: Truth) -> None:
    """How often landmarks are found in the grey pictures of a test, and how often something else is taken for one."""
    recording, names = open_recording(folder), [one.object for one in chosen]
    found, seen, wrong = np.zeros((3, len(names)), int)
    for frame in recording.frames():
        detected = {one.name: one.box for one in detector.detect(frame.image, recording.camera)}
        for k, box in enumerate(truth.boxes(frame.info.index, names)):
            shown = None if box is None else clipped(box, detector.geometry)
            large = shown is not None and shown.height_rad >= TALL_RAD and shown.width_rad >= WIDE_RAD
            said = detected.get(chosen[k].name)
            right = said is not None and shown is not None and said.iou(shown) >= SAME_IOU
            seen[k] += large
            found[k] += large and right
            wrong[k] += said is not None and not right
    for k, one in enumerate(chosen):
        print(
            f"{folder.name}: {one.name} found in {found[k]} of {seen[k]} frames that show it, "
            f"something else taken for it in {wrong[k]} of {len(recording.infos)}"
        )


def figures(title: str, values: dict[str, Any]) -> str:
    metres = " | ".join(f"{values[key]:.2f}" for key in ("median_m", "mean_m", "p95_m", "max_m"))
    return (
        f"| {title} | {metres} | {100 * values['share_over_1m']:.0f} | {100 * values['lost_share']:.0f} | "
        f"{values['heading_median_deg']:.1f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--weights", type=Path, required=True, help="YOLOX-nano as ONNX")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--side", type=int, default=1000, help="of a picture, pixels")
    parser.add_argument("--out", type=Path, default=Path(".bench/ten_minutes"))
    parser.add_argument("--workers", type=int, default=2, help="processes that render")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    plan, chosen = plan_of(given.seed, given.side)
    garden, out = given.out / f"garden-{given.seed}-{given.side}", given.out / "run"
    render_plan(plan, garden, workers=given.workers)
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    clock, truth = Clock(), Truth(plan, "teach")
    truth.recording.rendering(0)  # the garden is built before the clock runs
    folder = out / "teach"
    shutil.copytree(garden / "teach", folder)
    taught(folder, given.weights, chosen, clock=clock, truth=truth)
    labels, onnx, located = out / "teach.landmarks", out / "garden.onnx", out / "garden.andante"
    with clock.step("`andante learn-landmarks`"):
        learnt = command(out / "learn.log", "learn-landmarks", labels, "-o", onnx)
    with clock.step("`andante map --landmarks`"):
        command(out / "map.log", "map", folder, "--landmarks", onnx, "-o", located)
    rows = []
    for test in TESTS:
        with clock.step(f"`andante evaluate` of {test}"):
            values = command(out / f"evaluate-{test}.log", "evaluate", located, garden / test)
        rows.append((f"{test}, with landmarks", values))
    plain = out / "plain.andante"
    command(out / "plain.log", "map", folder, "-o", plain)
    for test in TESTS:
        values = command(out / f"plain-{test}.log", "evaluate", plain, garden / test)
        rows.append((f"{test}, without", values))
    print(f"teach: {len(truth.recording.infos)} frames of {given.side} px, {', '.join(one.object for one in chosen)}\n")
    clock.print()
    print("\n| | median m | mean m | 95 % m | max m | > 1 m % | lost % | heading deg |")
    print(f"|---|{7 * '---:|'}")
    for title, values in sorted(rows, key=lambda row: row[0]):
        print(figures(title, values))
    print()
    for one in learnt["landmarks"]:
        print(f"{one['name']}: found in {one['found']:.0%} of held-out pictures, false {one['false_positives']:.0%}")
    labels_right(labels, chosen, truth)
    detector = LandmarkDetector.load(onnx)
    for test in TESTS:
        detections_right(detector, garden / test, chosen, Truth(plan, test))


if __name__ == "__main__":
    main()
