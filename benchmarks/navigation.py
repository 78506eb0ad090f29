"""Milliseconds a control step, and whether an hour of driving eats memory.

    python benchmarks/navigation.py [--navigator gradient] [--minutes 50] [--frames 3000] [--work .bench/navigation]

Learns from a rendered drive, a sight (gradient) or a map (graph), then drives from goal to goal for so many simulated
minutes, each image rendered where the robot is. Told are the parts of a control step (what a robot's computer does;
rendering is not among them) and the resident memory every five minutes. Needs the extra sim.
"""

import argparse
import gc
import time
from pathlib import Path

import numpy as np

from andante.data import Pose2D
from andante.evaluation.experiments import Scale
from andante.evaluation.experiments.cache import rendered
from andante.evaluation.experiments.navigation_world import (
    MAPPED,
    ROBOT_RADIUS_M,
    Lawn,
    navigation_plan,
    random_errands,
)
from andante.localization import make_tracker
from andante.mapping import build_map
from andante.navigation import (
    STAND,
    CommuteNavigator,
    Guarded,
    Limits,
    PlaceGraph,
    PlaceGraphNavigator,
    SlowCost,
    drive,
    learn_sight,
    tracked,
)
from andante.sfa import one_thread
from andante.simulator import Scene, SimulatedRobot, make_garden

SEED = 5
REPORT_S = 300.0
LIMITS = Limits(timeout_s=120.0)


def resident_mb() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6


def by_gradient(recording):
    """A goal to a navigator, and what localizes."""
    sight = learn_sight(recording)

    def steer(robot, goal):
        # The goal's picture was taken there: the robot is put there for it, and back.
        pose, robot.pose = robot.pose, goal
        seen = sight.slow(robot.step(STAND, 0.0).image)
        robot.pose = pose
        return CommuteNavigator(SlowCost.biharmonic(seen, sight.deltas), limits=LIMITS)

    return steer, sight.localize


def by_graph(recording):
    slowmap = build_map([recording])
    graph = PlaceGraph.of(slowmap)

    def steer(robot, goal):
        return Guarded(PlaceGraphNavigator(graph, Pose2D(goal.x_m, goal.y_m), LIMITS))

    return steer, tracked(make_tracker(slowmap))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--navigator", choices=("gradient", "graph"), default="gradient")
    parser.add_argument("--minutes", type=float, default=50.0)
    parser.add_argument("--frames", type=int, default=3000)
    parser.add_argument("--work", type=Path, default=Path(".bench/navigation"))
    options = parser.parse_args()
    plan = navigation_plan(SEED, Scale(frames=options.frames, image_px=300))
    start = time.perf_counter()
    recording = rendered(plan, options.work)[MAPPED]
    print(f"rendered in {time.perf_counter() - start:.0f} s")
    start = time.perf_counter()
    steer, localize = (by_gradient if options.navigator == "gradient" else by_graph)(recording)
    print(f"learnt from {options.frames} images in {time.perf_counter() - start:.1f} s")

    garden = make_garden(plan.garden)
    errands = random_errands(Lawn(garden), 500, SEED)
    robot = SimulatedRobot(
        Scene.of(garden.things),
        Pose2D(*errands[0].start),
        conditions=plan.sessions[0].conditions,
        camera=plan.camera,
        radius_m=ROBOT_RADIUS_M,
        range_reach_m=1.5,
    )
    milliseconds, simulated_s, told_s, arrived, begun = [], 0.0, 0.0, 0, time.perf_counter()
    goals = iter(errands * 10)
    with one_thread():
        while simulated_s < 60.0 * options.minutes:
            way = drive(robot, localize, steer(robot, Pose2D(*next(goals).goal, 0.0)))
            milliseconds.append(way.milliseconds)
            simulated_s += way.seconds
            arrived += way.arrived
            if simulated_s - told_s >= REPORT_S:
                told_s = simulated_s
                gc.collect()
                minutes, driven = simulated_s / 60.0, len(milliseconds)
                print(f"{minutes:4.0f} min: {resident_mb():.0f} MB, {driven} goals, {arrived} reached", flush=True)
    steps = np.concatenate(milliseconds)
    print(f"{len(steps)} control steps in {time.perf_counter() - begun:.0f} s, rendering included")
    print(f"ms a step: median {np.median(steps):.2f}, 99 % {np.quantile(steps, 0.99):.2f}, longest {steps.max():.1f}")


if __name__ == "__main__":
    main()
