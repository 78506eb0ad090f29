"""What slow features are of: maps over a simulated garden, an obstacle in it, place cells, head direction.

    python benchmarks/slow_maps.py [-o docs/images] [--work .bench/slow_maps] [--frames 3000] [--workers 2]

Trains the thesis' network (row-wise Fourier magnitudes, 20 linear, quadratic, time order; thesis 9.2) on a random drive
through the garden, and shows its outputs on a grid of places that it was not trained on. Then pixels, which keep the
heading: where the robot turns slowly and changes place fast, the slowest features are of its heading; where it turns
fast, of its place (Franzius, Sprekeler and Wiskott 2007; thesis 3.5). Needs the extras sim and sklearn.
"""

import argparse
import time
from pathlib import Path

import numpy as np
from scipy.ndimage import label

from andante.data import FloatArray
from andante.errors import LearningError
from andante.evaluation import SpatialMaps, axis_correlations, slow_feature_maps, sparse_code
from andante.evaluation.garden_plots import feature_maps
from andante.mapping import MapConfig, SlowMap, build_map
from andante.recordings import FolderRecording
from andante.simulator import (
    GardenSpec,
    GivenPoses,
    GridRun,
    InfieldRun,
    Plan,
    Session,
    SimulatedCamera,
    make_garden,
    render_plan,
)  # fmt: skip
from andante.simulator.obstacles import Obstacles
from andante.simulator.trajectories import room_m

CAMERA = SimulatedCamera(model="panorama", width_px=300, height_px=30, min_deg=5.0, max_deg=50.0)
SEED = 3
GRID_M = 0.5
UNITS = 16
PANORAMA = {"width_px": 300, "height_px": 30, "min_deg": 5.0, "max_deg": 50.0}
PLACES = MapConfig.thesis().with_values(
    {"panorama": PANORAMA, "learning": {"order": "temporal", "slow_features": UNITS, "edge_ridge": 0.0}}
)
PIXELS = MapConfig().with_values(
    {
        "panorama": {**PANORAMA, "width_px": 60, "height_px": 10},
        "features": {"kind": "flat", "normalise": False},
        "learning": {
            "order": "temporal", "expansion": "quadratic", "slow_features": 8, "pca_components": 100, "edge_ridge": 0.0,
            "ridge": 1e-3,
        },
    }
)  # fmt: skip


def headings_slow(garden: GardenSpec, frames: int) -> GivenPoses:
    """Somewhere else in every picture, turning by a few degrees only."""
    rng, made = np.random.default_rng(SEED), make_garden(garden)
    spots = rng.uniform(-garden.size_x_m / 2, garden.size_x_m / 2, (20 * frames, 2))
    spots = spots[room_m(made, spots) > 0.3][:frames]
    heading = np.cumsum(rng.normal(0.0, 0.12, len(spots)))
    return GivenPoses(poses=tuple((float(x), float(y), float(h)) for (x, y), h in zip(spots, heading, strict=True)))


def headings_fast(garden: GardenSpec, frames: int) -> GivenPoses:
    """A drive through the garden, with another heading in every picture."""
    rng = np.random.default_rng(SEED)
    way = InfieldRun(frames=frames, speed_m_s=1.34).drive(make_garden(garden), rng)
    headings = rng.uniform(-np.pi, np.pi, len(way))
    return GivenPoses(poses=tuple((float(x), float(y), float(h)) for (x, y), h in zip(way.xy_m, headings, strict=True)))


def plan(obstacle: bool, frames: int) -> Plan:
    garden = GardenSpec(seed=SEED, v_obstacle=obstacle)
    sessions = [
        Session(name="infield", seed=1, drive=InfieldRun(frames=frames, speed_m_s=1.34)),
        Session(name="grid", seed=2, drive=GridRun(spacing_m=GRID_M)),
    ]
    if not obstacle:
        sessions += [
            Session(name="turning_slowly", seed=3, drive=headings_slow(garden, frames)),
            Session(name="turning_fast", seed=4, drive=headings_fast(garden, frames)),
            Session(name="all_headings", seed=5, drive=GridRun(spacing_m=GRID_M, headings="random")),
        ]
    return Plan(garden=garden, camera=CAMERA, sessions=tuple(sessions))


def explained(inputs: FloatArray, targets: FloatArray) -> str:
    """Shares of variance (R²) of each target that a linear function of the inputs explains."""
    design = np.column_stack([inputs, np.ones(len(inputs))])
    left = targets - design @ np.linalg.lstsq(design, targets, rcond=None)[0]
    return " ".join(f"{share:.2f}" for share in 1 - left.var(axis=0) / targets.var(axis=0))


def report_places(title: str, maps: SpatialMaps, deltas: FloatArray) -> None:
    xy, slow = maps.places
    first, second, axis = axis_correlations(xy, slow[:, 0], slow[:, 1])
    print(f"{title}: {len(xy)} places, deltas of s1..s5 " + " ".join(f"{delta:.4f}" for delta in deltas[:5]))
    print(f"  |r| of s1, s2 with orthogonal axes, turned by {np.degrees(axis):.0f} degrees: {first:.2f} {second:.2f}")
    for count in (2, 5, 8):
        print(f"  R² of x, y from s1..s{count}, linear: {explained(slow[:, :count], xy)}")


def across(maps: SpatialMaps, obstacles: Obstacles, features: int = 5) -> tuple[float, float]:
    """Mean distance in slow feature space of places 1 m apart: those that the obstacle divides, and the others."""
    xy, slow = maps.places
    slow = slow[:, :features] / slow[:, :features].std(axis=0)
    first, second = np.triu_indices(len(xy), 1)
    apart = np.linalg.norm(xy[first] - xy[second], axis=1)
    near = (apart > 0.9) & (apart < 1.2)
    first, second = first[near], second[near]
    between = xy[first, None] + np.linspace(0.0, 1.0, 25)[None, :, None] * (xy[second] - xy[first])[:, None]
    divided = obstacles.clearance_m(between.reshape(-1, 2)).reshape(len(first), -1).min(axis=1) <= 0.0
    distance = np.linalg.norm(slow[first] - slow[second], axis=1)
    return float(distance[divided].mean()), float(distance[~divided].mean())


def report_obstacle(open_maps: SpatialMaps, divided_maps: SpatialMaps) -> None:
    things = make_garden(GardenSpec(seed=SEED, v_obstacle=True)).things
    wall = Obstacles.of(footprint for thing in things if thing.kind == "obstacle" for footprint in thing.footprints)
    for title, maps in (("without the obstacle", open_maps), ("with the obstacle", divided_maps)):
        through, free = across(maps, wall)
        print(f"  {title}: s1..s5 of places 1 m apart differ by {through:.2f} across its line, by {free:.2f} elsewhere "
              f"(ratio {through / free:.2f})")  # fmt: skip


def report_cells(maps: SpatialMaps) -> None:
    """How much of the garden a unit fires in, and in how many fields."""
    shares, fields = [], []
    for values in maps.values:
        known = np.isfinite(values)
        firing = np.nan_to_num(values, nan=-np.inf) > np.nanmax(values) / 2
        shares.append(firing.sum() / known.sum())
        fields.append(label(firing, np.ones((3, 3)))[1])
    print(f"place cells: {len(shares)} units fire (above half of their maximum) in a median share of "
          f"{np.median(shares):.0%} of the garden; {sum(count == 1 for count in fields)} in one field, "
          f"{sum(count == 2 for count in fields)} in two")  # fmt: skip


def slow_of(slowmap: SlowMap, recording: FolderRecording) -> FloatArray:
    return np.stack([slowmap.slow_features(frame.image) for frame in recording.frames()])


def report_headings(recordings: dict[str, FolderRecording]) -> None:
    test = recordings["all_headings"]
    poses = np.array([(i.reference.x_m, i.reference.y_m, i.reference.heading_rad) for i in test.infos])
    heading = np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    print("head direction and place from pixels, tested on places and headings of their own:")
    for name in ("turning_slowly", "turning_fast"):
        slow = slow_of(build_map([recordings[name]], PIXELS), test)
        print(f"  {name}: R² of cos, sin of the heading from s1, s2: {explained(slow[:, :2], heading)}, "
              f"of x, y: {explained(slow[:, :2], poses[:, :2])}; from s1..s8: {explained(slow, heading)} "
              f"and {explained(slow, poses[:, :2])}")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", type=Path, default=Path(".bench/slow_maps"))
    parser.add_argument("--work", type=Path, default=Path(".bench/slow_maps"))
    parser.add_argument("--frames", type=int, default=3000)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    options.o.mkdir(parents=True, exist_ok=True)
    began = time.perf_counter()
    gardens = {}
    for name, obstacle in (("open", False), ("obstacle", True)):
        rendered = render_plan(plan(obstacle, options.frames), options.work / name, workers=options.workers)
        gardens[name] = {recording.name: recording for recording in rendered}
        print(f"rendered {name} garden, {time.perf_counter() - began:.0f} s", flush=True)
    found = {}
    for name, recordings in gardens.items():
        slowmap = build_map([recordings["infield"]], PLACES)
        found[name] = slow_feature_maps(slowmap, recordings["grid"], UNITS)
        report_places(f"{name} garden", found[name], slowmap.model.deltas)
        garden = make_garden(GardenSpec(seed=SEED, v_obstacle=name == "obstacle"))
        shown = SpatialMaps(found[name].values[:8], found[name].x_m, found[name].y_m)
        feature_maps(shown, garden.obstacles).savefig(options.o / f"slow_features_{name}.png", dpi=110)
        if name == "open":
            try:
                code = sparse_code(slow_of(slowmap, recordings["infield"]), UNITS)
            except LearningError as error:
                print(f"place cells: {error}")
                continue
            rows = found[name].values.reshape(UNITS, -1).T
            cells = SpatialMaps(
                code.transform(rows).T.reshape(found[name].values.shape), found[name].x_m, found[name].y_m
            )
            report_cells(cells)
            feature_maps(cells, garden.obstacles, "unit ").savefig(options.o / "place_cells.png", dpi=80)
    report_obstacle(found["open"], found["obstacle"])
    report_headings(gardens["open"])
    print(f"{time.perf_counter() - began:.0f} s in all; pictures in {options.o}")


if __name__ == "__main__":
    main()
