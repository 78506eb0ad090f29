"""Images from where nobody drove: border runs are mapped, and a robot that crosses the lawn is located.

    python benchmarks/off_path.py [--seed 23] [--work .bench/off_path] [--size-x 15 --size-y 9] [--workers 2]

Renders a garden of that seed (the thesis' test of chapter 8 has 15 x 9 m, 1,083 border and 298 infield images; extra
sim): border runs of some 280 images in summer and autumn, infield runs of 298 images in summer under other light, in
autumn and in winter. Each row is one map and one infield run: errors in metres of the best hypothesis of every image,
single images without odometry, with imagined views and without; then what the particle filter makes of them. The
thesis has 0.72 m median and 1.04 m mean, structure-based localization 0.38 and 2.52 with 20 % beyond 3 m.
"""

import argparse
from pathlib import Path

import numpy as np

from andante.evaluation import Figures, evaluate, track
from andante.mapping import MapConfig, build_map
from andante.recordings import FolderRecording, open_recording
from andante.simulator import BorderRun, Conditions, GardenSpec, InfieldRun, Plan, Session, render_plan

INFIELD = InfieldRun(frames=298)
SESSIONS = (
    Session(name="border-summer", seed=1, drive=BorderRun()),
    Session(name="border-autumn", seed=2, drive=BorderRun(start=0.4), conditions=Conditions(season="autumn", hour=14)),
    Session(name="infield-summer", seed=3, drive=INFIELD, conditions=Conditions(hour=13, sun_energy=4.5, clouds=0.3)),
    Session(name="infield-autumn", seed=4, drive=INFIELD, conditions=Conditions(season="autumn", hour=9, clouds=0.8)),
    Session(name="infield-winter", seed=5, drive=INFIELD, conditions=Conditions(season="winter", overcast=True)),
)
MAPS = (("border-summer",), ("border-summer", "border-autumn"))


def line(title: str, figures: Figures) -> str:
    errors = f"{figures.median_m:.3f} / {figures.mean_m:.3f} / {figures.p95_m:.2f} / {figures.max_m:.2f}"
    over = f"{figures.share_over_1m:.1%} > 1 m, {figures.share_over_3m:.1%} > 3 m"
    sure = f"ok and > 1 m {figures.confident_wrong_share:.2%}, lost {figures.lost_share:.1%}"
    heading = f"heading {figures.heading_median_deg:.2f} / {figures.heading_p95_deg:.1f} deg"
    return f"  {title:22} {errors}   {over}, in radius {figures.coverage_90:.0%}, {sure}, {heading}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=23)
    parser.add_argument("--work", type=Path, default=Path(".bench/off_path"))
    parser.add_argument("--size-x", type=float, default=15.0)
    parser.add_argument("--size-y", type=float, default=9.0)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    garden = GardenSpec(seed=given.seed, size_x_m=given.size_x, size_y_m=given.size_y)
    folder = given.work / f"{given.seed}-{given.size_x:g}x{given.size_y:g}"
    if not folder.is_dir():
        render_plan(Plan(garden=garden, sessions=SESSIONS), folder, workers=given.workers)
    recordings: dict[str, FolderRecording] = {one.name: open_recording(folder / one.name) for one in SESSIONS}
    for mapped in MAPS:
        borders = [recordings[name] for name in mapped]
        slowmap = build_map(borders)
        plain = build_map(borders, MapConfig().with_values({"off_path": {"enabled": False}}))
        count = sum(len(one.infos) for one in borders)
        print(f"{' + '.join(mapped)}, {count} images mapped: median / mean / 95 % / max")
        for name, infield in recordings.items():
            if name.startswith("infield"):
                single = evaluate(slowmap, infield)
                milliseconds = np.median([1000 * frame.seconds for frame in single.run.frames])
                print(f" {name}, {milliseconds:.1f} ms an image")
                print(line("mapped places alone", evaluate(plain, infield).figures))
                print(line("with imagined views", single.figures))
                followed = track(slowmap, infield)
                if followed.figures is not None:
                    print(line("followed", followed.figures))


if __name__ == "__main__":
    main()
