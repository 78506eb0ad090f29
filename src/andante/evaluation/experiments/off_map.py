"""Whether a map knows what it does not know: images of mapped places against everything else."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from andante.data import Estimate, FloatArray, ImageArray, Status
from andante.evaluation.experiments.contenders import ANDANTE
from andante.evaluation.experiments.indoors import indoor_pictures
from andante.evaluation.experiments.long_term import permutations
from andante.evaluation.experiments.outcome import Cell, Outcome, Plot, Table
from andante.evaluation.experiments.plans import Scale, long_term_plan
from andante.evaluation.experiments.strangers import blinded, covered_lenses, smooth_noise, white_noise
from andante.evaluation.experiments.tracking import learned, mapped_sizes
from andante.evaluation.experiments.trials import Bench
from andante.localization import evidence_of
from andante.mapping import SlowMap
from andante.protocols import Recording
from andante.sfa import one_thread

ALL = "all kinds, equally often"
_STRANGE = 999  # tells this use of the seed from others
_OTHER_GARDEN = 1000  # added to the seed
_SESSIONS = 4
_PICTURES = {True: 200, False: 40}
_RANKS = {Status.OK: 3.0, Status.DEGRADED: 2.0, Status.LOST: 1.0, Status.OFF_MAP: 0.0}
_COLUMNS = ("images", "number", "area below the ROC curve", *(f"{status} [%]" for status in Status))
_NOTES = (
    "the area is the chance that an image of a mapped place, from an unseen session, has more likeness than one of the "
    "other kind",
    "a covered lens is a tight cap, one with light at its rim, or a hand; blinded are pictures of the mapped garden "
    "with at most every eighth pixel not burnt out",
)

Kinds = Mapping[str, Sequence[Estimate]]


def run_off_map(bench: Bench, seed: int, scale: Scale) -> Outcome:
    """Estimates of single images of both sorts, with few and with all but one sessions mapped."""
    names = [session.name for session in bench.plan.sessions]
    order = permutations(names, 1, seed)[0]
    other = bench.beside(
        long_term_plan(seed + _OTHER_GARDEN, scale.model_copy(update={"sessions": min(_SESSIONS, scale.sessions)}))
    )
    pictures = _strangers(bench, other, order[-1], seed, _PICTURES[scale.frames >= 250])
    found = {}
    for size in mapped_sizes(len(names)):
        slowmap = learned(bench, order[:size])
        mapped = [one for name in order[size : size + _SESSIONS] for one in _seen(slowmap, _all(bench.recording(name)))]
        found[size] = (mapped, {kind: _seen(slowmap, images) for kind, images in pictures.items()})
        bench.progress("off the map", len(found), len(mapped_sizes(len(names))))
    tables = tuple(_table(size, *seen) for size, seen in found.items())
    figures = {str(size): _figures(*seen) for size, seen in found.items()}
    return Outcome(tables, (_plot(*found[max(found)]),), {"by_sessions": figures}, (ANDANTE,), _NOTES)


def likenesses(estimates: Iterable[Estimate]) -> FloatArray:
    """(n,) how much each image looks like a mapped place; without one it shows nothing.

    Where no estimate has a likeness at all, the rank of its status stands for it.
    """
    estimates = list(estimates)
    if all(one.likeness is None for one in estimates):
        return np.array([_RANKS[one.status] for one in estimates])
    return np.array([one.likeness or 0.0 for one in estimates])


def area_below(mapped: FloatArray, strange: FloatArray) -> float:
    """The area under the ROC curve: how often a mapped score is above a strange one, ties counting half."""
    below = np.searchsorted(np.sort(strange), mapped, side="left")
    up_to = np.searchsorted(np.sort(strange), mapped, side="right")
    return float((below + up_to).mean() / 2 / len(strange))


def roc(mapped: FloatArray, strange: FloatArray) -> tuple[FloatArray, FloatArray]:
    """False and true positive rates (t,) for all thresholds, from none to all taken for mapped places."""
    thresholds = np.unique(np.concatenate([mapped, strange]))[::-1]
    rates = [
        1 - np.searchsorted(np.sort(scores), thresholds, side="left") / len(scores) for scores in (strange, mapped)
    ]
    return np.append(0.0, rates[0]), np.append(0.0, rates[1])


def _strangers(bench: Bench, other: Bench, unseen: str, seed: int, count: int) -> dict[str, list[ImageArray]]:
    """Pictures of every kind; those that begin with the mapped garden begin with an unseen session of it."""
    rng = np.random.default_rng([seed, _STRANGE])
    camera, side = bench.plan.camera, bench.plan.camera.width_px
    own = list(_spread(bench.recording(unseen), count))
    gardens = [other.recording(session.name) for session in other.plan.sessions]
    noise = [(white_noise, smooth_noise)[number % 2](rng, side) for number in range(count)]
    return {
        "another garden": [image for garden in gardens for image in _spread(garden, max(1, count // len(gardens)))],
        "indoors": list(indoor_pictures(rng, camera, count)),
        "covered lens": list(covered_lenses(rng, iter(own))),
        "blinded": list(blinded(rng, iter(own))),
        "noise": noise,
    }


def _seen(slowmap: SlowMap, images: Iterable[ImageArray]) -> list[Estimate]:
    with one_thread():
        return [evidence_of(slowmap, image).estimate for image in images]


def _all(recording: Recording) -> Iterator[ImageArray]:
    return (frame.image for frame in recording.frames())


def _spread(recording: Recording, count: int) -> Iterator[ImageArray]:
    """At most so many pictures, evenly spread."""
    chosen = np.unique(np.linspace(0, len(recording.infos) - 1, count).astype(int)).tolist()
    return (frame.image for frame in recording.frames(chosen))


def _scores(mapped: Sequence[Estimate], strange: Kinds) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Likenesses of all images on one scale."""
    sizes = np.cumsum([len(mapped), *map(len, strange.values())])
    first, *others = np.split(likenesses([*mapped, *(one for each in strange.values() for one in each)]), sizes[:-1])
    return first, dict(zip(strange, others, strict=True))


def _areas(mapped: Sequence[Estimate], strange: Kinds) -> dict[str, float]:
    on, off = _scores(mapped, strange)
    areas = {kind: area_below(on, scores) for kind, scores in off.items()}
    return {**areas, ALL: float(np.mean(list(areas.values())))}


def _table(size: int, mapped: Sequence[Estimate], strange: Kinds) -> Table:
    areas = _areas(mapped, strange)
    rows: list[tuple[Cell, ...]] = [("mapped garden, unseen session", len(mapped), None, *_statuses(mapped))]
    rows += [(kind, len(seen), areas[kind], *_statuses(seen)) for kind, seen in strange.items()]
    every = [one for seen in strange.values() for one in seen]
    return Table(f"{size} mapped", _COLUMNS, (*rows, (ALL, len(every), areas[ALL], *_statuses(every))))


def _statuses(estimates: Sequence[Estimate]) -> tuple[float, ...]:
    counts = Counter(one.status for one in estimates)
    return tuple(100 * counts[status] / max(1, len(estimates)) for status in Status)


def _figures(mapped: Sequence[Estimate], strange: Kinds) -> dict[str, Any]:
    shares = {kind: _named(seen) for kind, seen in {"mapped garden": mapped, **strange}.items()}
    return {"area": _areas(mapped, strange), "statuses_percent": shares}


def _named(estimates: Sequence[Estimate]) -> dict[str, float]:
    return dict(zip(map(str, Status), _statuses(estimates), strict=True))


def _plot(mapped: Sequence[Estimate], strange: Kinds) -> Plot:
    from andante.evaluation.experiments.track_plots import receiver_operating

    on, off = _scores(mapped, strange)
    curves = {kind: (*roc(on, scores), area_below(on, scores)) for kind, scores in off.items()}
    return Plot("", "Images of mapped places against others, all but one sessions mapped.", receiver_operating(curves))
