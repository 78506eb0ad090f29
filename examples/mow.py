"""Mow a lawn lane by lane (thesis figure 1.2): map it, lay lanes over what was mapped, drive them, say what was cut.

    python examples/mow.py [--seed 5] [--frames 3000] [--lane 0.3] [-o mow.png]

The robot is simulated and sees what its camera renders; only the picture and the share at the end use the truth.
Needs the extra sim.
"""

import argparse
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

import andante as an
from andante.simulator import (
    GardenSpec,
    InfieldRun,
    Plan,
    Scene,
    Session,
    SimulatedCamera,
    SimulatedRecording,
    SimulatedRobot,
    Wall,
    make_garden,
)

CUT_M = 0.4  # how wide the knife cuts
CELL_M = 0.1
MAPPED_M = 0.25  # nearer than this to where it was driven, the lawn counts as mapped
DRIVEN_M = 0.1  # and nearer than this, the robot can go there


def plan_of(seed: int, frames: int) -> Plan:
    """One long drive over a lawn of 5 x 10 m with a wall on it."""
    wall = Wall(points_m=((-0.9, 0.8), (0.0, -0.1), (0.9, 0.8)))
    camera = SimulatedCamera(model="panorama", width_px=300, height_px=30, min_deg=5, max_deg=50, antialias=False)
    session = Session(name="first", seed=seed, drive=InfieldRun(frames=frames))
    garden = GardenSpec(seed=seed, size_x_m=8, size_y_m=14, walls=(wall,))
    return Plan(garden=garden, camera=camera, sessions=(session,))


def cells_of(graph: an.PlaceGraph, near_m: float) -> np.ndarray:
    """(n, 2) the cells of a grid that are so near to where it was driven."""
    low, high = graph.xy_m.min(axis=0) - MAPPED_M, graph.xy_m.max(axis=0) + MAPPED_M
    axes = (np.arange(a, b, CELL_M) for a, b in zip(low, high, strict=True))
    cells = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    return cells[[graph.off_m(cell) <= near_m for cell in cells]]


def lanes_over(cells: np.ndarray, lane_m: float) -> list[np.ndarray]:
    """(2, 2) both ends of every lane along y, from side to side, to and fro; what is not mapped parts a lane in two."""
    lanes, (left, right) = [], (cells[:, 0].min(), cells[:, 0].max())
    for number, x in enumerate(np.linspace(left, right, int(np.ceil((right - left) / lane_m)) + 1)):
        y = np.unique(cells[np.abs(cells[:, 0] - x) <= CELL_M / 2, 1].round(3))
        parts = [part for part in np.split(y, np.flatnonzero(np.diff(y) > 3 * CELL_M) + 1) if np.ptp(part) > CUT_M]
        forth = [np.array([(x, part[0]), (x, part[-1])]) for part in parts]
        lanes += forth if number % 2 == 0 else [lane[::-1] for lane in reversed(forth)]
    return lanes


def mow(robot: SimulatedRobot, slowmap: an.SlowMap, graph: an.PlaceGraph, lanes: list[np.ndarray]) -> np.ndarray:
    """Drive all lanes; gives the true way (m, 2)."""
    localize, way = an.tracked(an.make_tracker(slowmap)), []
    for number, end in enumerate(np.concatenate(lanes)):
        navigator = an.PlaceGraphNavigator(graph, an.pose_goal(*end).pose, an.Limits(timeout_s=120), tolerance_m=0.15)
        run = an.drive(
            robot, localize, an.Guarded(navigator), progress=lambda *_: way.append((robot.pose.x_m, robot.pose.y_m))
        )
        if not run.arrived:
            print(f"lane {number // 2 + 1} of {len(lanes)}: {run.outcome}, {run.reason}")
    return np.array(way)


def main() -> None:
    """Map, plan, mow, draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--frames", type=int, default=3000, help="images to map with")
    parser.add_argument("--lane", type=float, default=0.3, help="metres from lane to lane")
    parser.add_argument("-o", "--output", default="mow.png")
    options = parser.parse_args()

    plan = plan_of(options.seed, options.frames)
    slowmap = an.build_map([SimulatedRecording(plan, "first")])
    graph = an.PlaceGraph.of(slowmap)
    cells = cells_of(graph, MAPPED_M)
    lanes = lanes_over(cells_of(graph, DRIVEN_M), options.lane)

    garden = make_garden(plan.garden)
    start = an.Pose2D(*lanes[0][0], 0.0)
    robot = SimulatedRobot(Scene.of(garden.things), start, camera=plan.camera, range_reach_m=1.5, seed=options.seed)
    way = mow(robot, slowmap, graph, lanes)
    cut = cKDTree(way).query(cells)[0] <= CUT_M / 2
    driven = sum(np.hypot(*(b - a)) for a, b in pairwise(way))
    print(f"{len(lanes)} lanes, {driven:.0f} m driven, {cut.mean():.1%} of {len(cells) * CELL_M**2:.1f} m² cut")

    figure = Figure(figsize=(5, 8), layout="constrained")
    axes = figure.add_subplot()
    axes.scatter(*cells.T, c=np.where(cut, "#8fc98a", "#d9b26b"), s=9, marker="s", lw=0)
    axes.plot(*way.T, "-", color="#1f5fae", lw=0.8)
    for thing in garden.things:
        if thing.kind == "wall":
            for corners in thing.mesh.corners:
                axes.fill(*corners[:, :2].T, color="#20242a")
    axes.set(aspect="equal", xlabel="x in m", ylabel="y in m", title=f"{cut.mean():.1%} cut")
    figure.savefig(options.output, dpi=100)


if __name__ == "__main__":
    main()
