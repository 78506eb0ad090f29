"""The picture in the README: winter images localized in a map of summer and autumn.

python benchmarks/result_figure.py [--data ../shared/data] [-o docs/images/result.png]
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from andante.evaluation import Evaluation, evaluate
from andante.evaluation.figures import errors_of
from andante.mapping import MapConfig, build_map
from andante.recordings import open_recording


def cumulative(axes: plt.Axes, evaluation: Evaluation, label: str, **style: object) -> None:
    errors = np.sort(errors_of(evaluation.run, "m"))
    axes.plot(np.maximum(errors, 0.01), 100 * np.arange(1, len(errors) + 1) / len(errors), label=label, **style)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("-o", type=Path, default=Path("docs/images/result.png"))
    options = parser.parse_args()
    train = [open_recording(options.data / "garden_a" / f"border_{season}") for season in ("summer", "autumn")]
    winter = open_recording(options.data / "garden_a" / "border_winter")
    slowmap = build_map(train)
    found = evaluate(slowmap, winter)
    thesis = evaluate(build_map(train, MapConfig.thesis()), winter)

    truth = np.array([(f.info.reference.x_m, f.info.reference.y_m) for f in found.run.frames])
    guess = np.array([(f.estimate.hypotheses[0].x_m, f.estimate.hypotheses[0].y_m) for f in found.run.frames])
    errors = errors_of(found.run, "m")
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.4), width_ratios=(1, 1.15), layout="constrained")
    left.plot(*truth.T, color="0.8", linewidth=6, solid_capstyle="round", label="driven in winter")
    colours = left.scatter(
        *guess.T, c=np.maximum(errors, 0.01), s=9, cmap="viridis_r", norm=matplotlib.colors.LogNorm(0.01, 10), zorder=3
    )
    figure.colorbar(colours, ax=left, label="error in m", shrink=0.8)
    left.set(xlabel="x in m", ylabel="y in m", title="Snow, located in a map of summer and autumn", aspect="equal")
    left.title.set_fontsize(10)
    cumulative(right, found, "andante default", color="#1f6fb4", linewidth=2.2)
    cumulative(right, thesis, "thesis choices", color="#c77f0a", linewidth=1.6)
    right.set(xscale="log", xlim=(0.01, 15), ylim=(0, 101), xlabel="error in m", ylabel="share of images in %")
    right.set_title("Single images, no odometry (rendered garden)", fontsize=10)
    right.grid(alpha=0.3)
    right.legend(frameon=False, loc="lower right")
    options.o.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(options.o, dpi=110)


if __name__ == "__main__":
    main()
