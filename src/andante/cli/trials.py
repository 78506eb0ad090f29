"""How commands show what a map was worth on drives left out: a table, and which season is missing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any

from andante.cli.output import hint, print_table

_CONSPICUOUS = 1.5


def held_out_mean(trial: Mapping[str, Any]) -> float | None:
    """The mean error over all drives that were held out, ``None`` where there was only one."""
    if trial["kind"] != "sessions":
        return None
    frames = sum(fold["n"] for fold in trial["folds"])
    return sum(fold["n"] * fold["mean"] for fold in trial["folds"]) / frames if frames else None


def print_trials(trial: Mapping[str, Any], unit: str) -> None:
    """The table of a map's cross-validation, and a hint where one condition stands out or nothing could be tried."""
    columns = ("left out", "conditions", "images", *(f"{name} [{unit}]" for name in ("median", "mean", "p95", "max")))
    names = ("n", "median", "mean", "p95", "max")
    rows = [(fold["left_out"], _conditions(fold), *(fold[name] for name in names)) for fold in trial["folds"]]
    parts = "drives" if trial["kind"] == "sessions" else "parts of the drive"
    print_table(f"Errors on {parts} left out", columns, rows)
    if trial["kind"] == "none":
        hint("too few images to leave some out: errors and radius of this map are untested")
    elif trial["kind"] == "blocks":
        hint(
            "of one drive only parts can be left out, which lie further from the rest than another drive would: these "
            "errors and the radius are large, and know no other light or season; map a second drive"
        )
    elif missing := missing_condition(trial, unit):
        hint(missing)


def print_closings(closings: Sequence[Mapping[str, Any]]) -> None:
    """How drives were brought into one frame by their odometry; nothing where positions were given."""
    if not closings:
        return
    columns = ("drive", "heading off [deg]", "gap closed [m]", "places agreed", "rejected", "apart [m]")
    print_table("Odometry brought into one frame", columns, [_closing(one) for one in closings])
    for one in closings:
        if one["hint"]:
            hint(one["hint"])


def _closing(one: Mapping[str, Any]) -> tuple[object, ...]:
    turned = one["heading_error_rad"]
    degrees_off = None if turned is None else math.degrees(turned)
    return one["name"], degrees_off, one["position_error_m"], one["kept"], one["rejected"], one["residual_m"]


def missing_condition(trial: Mapping[str, Any], unit: str) -> str | None:
    """Which condition the map would be worst at without its drive: there another drive would help most."""
    folds = trial["folds"]
    if len(folds) < 2:
        return None
    worst = max(folds, key=lambda fold: fold["mean"])
    usual = median(fold["mean"] for fold in folds if fold is not worst)
    if worst["mean"] < _CONSPICUOUS * usual:
        return None
    described = _conditions(worst)
    like = f" ({described})" if described else ""
    return (
        f"least known is what {worst['left_out']}{like} shows: without it {worst['mean']:.3f} {unit} in the mean, the "
        f"others {usual:.3f} in the median; if its poses are right, another drive like it would help most"
    )


def _conditions(fold: Mapping[str, Any]) -> str | None:
    """Season, weather, light and time of a held-out part, where its recordings say so."""
    told = []
    for conditions in fold["conditions"]:
        words = {key: value for key, value in conditions.items() if key in {"season", "weather", "light", "time"}}
        told.append(", ".join(str(value) for value in words.values()))
    return " + ".join(dict.fromkeys(word for word in told if word)) or None
