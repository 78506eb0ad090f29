"""Errors of the default, the thesis' choices and plain baselines on the same splits, as one table.

    python benchmarks/accuracy.py [--data ../shared/data] [--only raw [--years FOLDER]]

Maps whole sessions and localizes single images of another one, without odometry. ``garden_a`` is rendered, ``sussex``
and ``nordland`` are real; nordland has place numbers instead of metres. Errors are over all images with a reference,
whatever the status of the estimate. ``raw`` compares networks that learn from whole images; ``--years`` is a folder
with sessions as ``andante experiment long-term`` renders them: the first four are mapped, the last is localized.
"""

import argparse
import time
import warnings
from collections.abc import Iterator
from itertools import product
from pathlib import Path

from andante.evaluation import Figures, evaluate
from andante.mapping import MapConfig, build_map
from andante.recordings import open_recording

GARDEN = (
    (["summer"], "autumn"),
    (["summer"], "winter"),
    (["winter"], "autumn"),
    (["summer", "autumn"], "winter"),
    (["autumn", "winter"], "summer"),
    (["summer", "winter"], "autumn"),
)

RAW = (GARDEN[0], GARDEN[1], GARDEN[3])
READOUTS = ("local", "polynomial")


def splits() -> list[tuple[str, list[str], str]]:
    """(title, recordings to map, recording to localize)."""
    found = [
        (f"garden {'+'.join(train)} -> {test}", [f"garden_a/border_{one}" for one in train], f"garden_a/border_{test}")
        for train, test in GARDEN
    ]
    found.append(("sussex train -> binary", ["sussex_train"], "sussex_binary"))
    return found


def row(title: str, what: str, figures: Figures) -> str:
    shares = f"{figures.share_over_1m:.1%} | {figures.share_over_3m:.1%}"
    metres = f"{figures.median_m:.3f} | {figures.mean_m:.3f} | {figures.p95_m:.2f} | {figures.max_m:.1f}"
    return f"| {title} | {what} | {metres} | {shares} |"


def metric_table(data: Path) -> None:
    print("| split | localizer | median m | mean m | 95 % m | max m | > 1 m | > 3 m |")
    print("|---|---|---|---|---|---|---|---|")
    for title, train, test in splits():
        recordings = [open_recording(data / one) for one in train]
        found = evaluate(build_map(recordings), open_recording(data / test), baselines=True)
        print(row(title, "**andante default**", found.figures))
        thesis = evaluate(build_map(recordings, MapConfig.thesis()), open_recording(data / test))
        print(row(title, "thesis choices", thesis.figures))
        for name, figures in found.baselines.items():
            print(row(title, name, figures), flush=True)


def place_table(data: Path) -> None:
    print("\n| split | localizer | within 1 place | 3 | 10 |\n|---|---|---|---|---|")
    train, test = (open_recording(data / name) for name in ("nordland_summer", "nordland_winter"))
    for what, config in (("andante default (flat)", MapConfig()), ("thesis choices", MapConfig.thesis())):
        found = evaluate(build_map([train], config), test, baselines=what.startswith("andante"))
        for name, figures in {what: found.figures, **found.baselines}.items():
            places = figures.places
            shares = (places.share_within_1, places.share_within_3, places.share_within_10)
            cells = " | ".join(f"{share:.1%}" for share in shares)
            print(f"| nordland summer -> winter | {name} | {cells} |", flush=True)


def raw_configs() -> dict[str, MapConfig]:
    """Features by name, our own readouts and the thesis' left open."""
    kinds = {kind: MapConfig().with_values({"features": {"kind": kind}}) for kind in ("fourier", "flat", "pixels")}
    return {
        "default (fourier)": kinds["fourier"],
        "flat pixels": kinds["flat"],
        "**network (pixels)**": kinds["pixels"],
        "thesis (raw images)": MapConfig.thesis_pixels(),
        "thesis (Fourier)": MapConfig.thesis(),
    }


def raw_splits(data: Path, years: Path | None) -> Iterator[tuple[str, list[Path], Path]]:
    for train, test in RAW:
        folders = [data / f"garden_a/border_{one}" for one in train]
        yield f"garden {'+'.join(train)} -> {test}", folders, data / f"garden_a/border_{test}"
    if years is not None:
        sessions = sorted(path for path in years.iterdir() if (path / "recording.toml").exists())
        yield f"years {len(sessions[:4])} drives -> {sessions[-1].name}", sessions[:4], sessions[-1]


def raw_table(data: Path, years: Path | None) -> None:
    print("| split | features | readout | median m | mean m | 95 % m | s to map |\n|---|---|---|---|---|---|---|")
    for title, train, test in raw_splits(data, years):
        recordings = [open_recording(folder) for folder in train]
        for (name, config), kind in product(raw_configs().items(), READOUTS):
            start = time.perf_counter()
            slowmap = build_map(recordings, config.with_values({"readout": {"kind": kind}}))
            seconds = time.perf_counter() - start
            found = evaluate(slowmap, open_recording(test)).figures
            metres = f"{found.median_m:.3f} | {found.mean_m:.3f} | {found.p95_m:.2f}"
            print(f"| {title} | {name} | {kind} | {metres} | {seconds:.1f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--only", choices=("metric", "places", "raw"))
    parser.add_argument("--years", type=Path, help="sessions of one garden, for the raw table")
    options = parser.parse_args()
    warnings.simplefilter("error")
    if options.only in (None, "metric"):
        metric_table(options.data)
    if options.only in (None, "places"):
        place_table(options.data)
    if options.only in (None, "raw"):
        raw_table(options.data, options.years)


if __name__ == "__main__":
    main()
