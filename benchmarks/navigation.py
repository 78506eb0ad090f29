"""Milliseconds a control step, and whether an hour of driving eats memory.

    python benchmarks/navigation.py [--minutes 50] [--frames 3000] [--work .bench/navigation]

Learns a sight from a rendered drive, then drives from goal to goal for so many simulated minutes, each image rendered
where the robot is. Told are the parts of a control step (what a robot's computer does; rendering is not among them)
and the resident memory every five minutes. Needs the extra sim.
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
from andante.navigation import STAND, CommuteNavigator, Limits, SlowCost, drive, learn_sight
from andante.sfa import one_thread
from andante.simulator import Scene, SimulatedRobot, make_garden

SEED = 5
REPORT_S = 300.0


def resident_mb() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=50.0)
    parser.add_argument("--frames", type=int, default=3000)
    parser.add_argument("--work", type=Path, default=Path(".bench/navigation"))
    options = parser.parse_args()
    plan = navigation_plan(SEED, Scale(frames=options.frames, image_px=300))
    start = time.perf_counter()
    recording = rendered(plan, options.work)[MAPPED]
    print(f"rendered in {time.perf_counter() - start:.0f} s")
    start = time.perf_counter()
    sight = learn_sight(recording)
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
            # The goal's picture was taken there: the robot is put there for it, and back.
            pose, errand = robot.pose, next(goals)
            robot.pose = Pose2D(*errand.goal, 0.0)
            goal = sight.slow(robot.step(STAND, 0.0).image)
            robot.pose = pose
            navigator = CommuteNavigator(SlowCost.biharmonic(goal, sight.deltas), limits=Limits(timeout_s=120.0))
            way = drive(robot, sight.localize, navigator)
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
