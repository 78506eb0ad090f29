"""How well drives fit truth, and each other, when only odometry and features are known.

    python benchmarks/closure.py [--drives 20] [--recordings DIR ...]

First simulated odometry of one lap around a garden of 15 x 15 m, nothing rendered: error against truth before and after
closing, after the best rotation and translation of the drive itself (no scale). Ways to close: the heading error spread
over the turns (Einecke et al. 2018) or over time, positions integrated again and the rest of the gap spread by arc
length; and ``close_wire_loop``. Then, where folders with reference poses are given, recordings of one garden in the
frame of the first of them: ``absolute`` is the distance from truth after the best rotation and translation of all
drives together, ``between`` how wrongly frames of one true place (less than 0.15 m apart) in two drives lie to each
other; both as median / mean / 95 % / max.
"""

import argparse
import time
from itertools import combinations
from pathlib import Path

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray, Trajectory
from andante.mapping import MapConfig
from andante.mapping.frontend import FrontEnd, camera_and_size
from andante.recordings import open_recording
from andante.sequences import close_wire_loop, register_sessions
from andante.sequences.pose_graph import Steps
from andante.simulator import Plan, Session, SimulatedRecording

Drive = tuple[FloatArray, FloatArray, FloatArray]
"""Times (n,), odometry (n, 3), truth (n, 3)."""


def simulated(count: int) -> list[Drive]:
    starts = np.random.default_rng(5).random(count)
    sessions = tuple(
        Session(
            name=f"drive-{number}",
            seed=100 + number,
            drive={"kind": "border", "start": float(start), "clockwise": number % 2 == 1},
        )
        for number, start in enumerate(starts)
    )
    plan = Plan(garden={"seed": 3, "size_x_m": 15.0, "size_y_m": 15.0}, sessions=sessions)
    return [poses(SimulatedRecording(plan, one.name).infos) for one in sessions]


def poses(infos) -> Drive:
    odometry, truth = Trajectory.of(infos, "odometry"), Trajectory.of(infos, "reference")
    return (
        odometry.timestamp_s,
        np.column_stack([odometry.xy_m, odometry.heading_rad]),
        np.column_stack([truth.xy_m, truth.heading_rad]),
    )


def spread(times: FloatArray, odometry: FloatArray, turn_share: float) -> FloatArray:
    """The heading error spread over turns and time, the rest of the gap by arc length; the next step closes the lap."""
    path = np.concatenate([odometry, odometry[-1:]])
    path[-1] += odometry[-1] - odometry[-2]
    steps = Steps.of(path, np.append(times, 2 * times[-1] - times[-2]))
    turned = np.append(0.0, np.cumsum(np.abs(steps.turn_rad)))
    passed = np.append(0.0, np.cumsum(steps.duration_s))
    share = turn_share * turned / turned[-1] + (1 - turn_share) * passed / passed[-1]
    heading = path[:, 2] - wrapped(path[-1:, 2] - path[0, 2]) * share
    closed = steps.integrated(path[0, :2], heading)
    way = np.append(0.0, np.cumsum(np.hypot(steps.ahead_m, steps.left_m)))
    closed[:, :2] -= (way / way[-1])[:, None] * (closed[-1] - closed[0])[:2]
    return closed[:-1]


def aligned(found: FloatArray, truth: FloatArray) -> FloatArray:
    """Poses (n, 3) after the rotation and translation that fit the true positions best."""
    centre, goal = found[:, :2].mean(axis=0), truth[:, :2].mean(axis=0)
    a, b = found[:, :2] - centre, truth[:, :2] - goal
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    matrix = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.column_stack([a @ matrix.T + goal, found[:, 2] + angle])


def errors_of(found: FloatArray, truth: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances (n,) in metres and heading errors (n,) in degrees after the best rotation and translation."""
    off = aligned(found, truth) - truth
    return np.hypot(off[:, 0], off[:, 1]), np.degrees(np.abs(wrapped(off[:, 2])))


def closing_tables(count: int) -> None:
    drives = simulated(count)
    ways = {
        "odometry": lambda _, odometry: odometry,
        "spread over turns": lambda times, odometry: spread(times, odometry, 1.0),
        "spread over time": lambda times, odometry: spread(times, odometry, 0.0),
        "half, half": lambda times, odometry: spread(times, odometry, 0.5),
        "**close_wire_loop**": lambda times, odometry: close_wire_loop(odometry, times).poses,
    }
    errors = {name: [errors_of(way(times, path), truth) for times, path, truth in drives] for name, way in ways.items()}
    print("| drive | heading off rad | gap m | bias mrad/s | before mean / max m | after | heading after deg |")
    print("|---|---|---|---|---|---|---|")
    for number, (times, odometry, _) in enumerate(drives):
        closed = close_wire_loop(odometry, times)
        before, (after, heading) = errors["odometry"][number][0], errors["**close_wire_loop**"][number]
        print(
            f"| {number} | {closed.heading_error_rad:+.3f} | {closed.position_error_m:.2f} | "
            f"{1e3 * closed.gyro_bias_rad_s:+.2f} | {before.mean():.3f} / {before.max():.3f} | "
            f"{after.mean():.3f} / {after.max():.3f} | {heading.mean():.2f} |"
        )
    print(f"\n| {count} drives | median of means m | mean m | largest m | heading mean deg | largest deg |")
    print("|---|---|---|---|---|---|")
    for name, found in errors.items():
        metres, degrees = np.array([one[0].mean() for one in found]), np.array([one[1].mean() for one in found])
        print(
            f"| {name} | {np.median(metres):.3f} | {metres.mean():.3f} | {max(one[0].max() for one in found):.3f} | "
            f"{degrees.mean():.2f} | {max(one[1].max() for one in found):.2f} |"
        )


def seen(folder: Path) -> tuple[FloatArray, Drive]:
    recording, config = open_recording(folder), MapConfig()
    front = FrontEnd(*camera_and_size(recording), config.panorama, config.features)
    frames = list(recording.frames())
    return np.stack([front.features(frame.image) for frame in frames]), poses([frame.info for frame in frames])


def between(truths: list[FloatArray], found: FloatArray) -> FloatArray:
    """(k,) metres by which frames of one true place lie wrongly to each other; ``found`` is all of them aligned."""
    parts = np.split(found, np.cumsum([len(truth) for truth in truths])[:-1])
    wrong = []
    for one, other in combinations(range(len(truths)), 2):
        apart = np.linalg.norm(truths[one][:, None, :2] - truths[other][:, :2], axis=2)
        nearest, near = apart.argmin(axis=1), apart.min(axis=1) < 0.15
        off = parts[one] - parts[other][nearest] - truths[one][:, :2] + truths[other][nearest, :2]
        wrong.append(np.linalg.norm(off[near], axis=1))
    return np.concatenate(wrong)


def summary(metres: FloatArray) -> str:
    low, high = np.quantile(metres, [0.5, 0.95])
    return f"{low:.3f} / {metres.mean():.3f} / {high:.3f} / {metres.max():.3f}"


def registration_tables(folders: list[Path]) -> None:
    features, drives = zip(*(seen(folder) for folder in folders), strict=True)
    times, odometry, truths = (list(column) for column in zip(*drives, strict=True))
    print(
        "\n| drives laid over each other | absolute m | between m | heading mean deg | seconds |\n|---|---|---|---|---|"
    )
    for name, anchor_m in (("as a whole", 1e3), ("**bent**", 0.15)):
        start = time.perf_counter()
        sessions = register_sessions(features, odometry, times, anchor_m=anchor_m)
        seconds = time.perf_counter() - start
        found, true = np.concatenate([one.poses for one in sessions]), np.concatenate(truths)
        off, heading = errors_of(found, true)
        pairs = between(truths, aligned(found, true)[:, :2])
        print(f"| {name} | {summary(off)} | {summary(pairs)} | {heading.mean():.2f} | {seconds:.1f} |")
    print("\n| recording | heading off rad | gap m | scale | kept | rejected | residual m |\n" + 7 * "|---" + "|")
    for folder, session in zip(folders, sessions, strict=True):
        report, closing, whole = session.report, session.report.closing, session.report.registration
        ends = f"{closing.heading_error_rad:+.3f} | {closing.position_error_m:.2f}" if closing else "- | -"
        print(
            f"| {folder.name} | {ends} | {whole.scale if whole else 1.0:.4f} | {report.kept} | {report.rejected} | "
            f"{report.residual_m:.3f} |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=20)
    parser.add_argument("--recordings", type=Path, nargs="+", default=[])
    options = parser.parse_args()
    closing_tables(options.drives)
    if options.recordings:
        registration_tables(options.recordings)


if __name__ == "__main__":
    main()
