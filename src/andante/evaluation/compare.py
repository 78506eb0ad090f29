"""All methods on one split: each learns once from the same drives, then localizes the same unseen ones (thesis 8)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from andante.baselines import MapLocalizer, Method, StagedLocalizer
from andante.data import PoseSource
from andante.errors import AndanteError, LearningError
from andante.evaluation.answers import Answers
from andante.evaluation.frame_fit import fit_robustly
from andante.evaluation.hardware import Hardware
from andante.evaluation.split import check_split
from andante.evaluation.staged import answers_of
from andante.evaluation.tracking import run_tracker
from andante.localization import make_tracker
from andante.mapping import Progress
from andante.protocols import Recording

OWN = "andante"
"""The method that the others are measured against."""


@dataclass(frozen=True, eq=False)
class Entry:
    """One method: what learning cost, and what it said of every test; or the ``failure`` that it ended with.

    ``followed`` is what the tracker made of its single images where a test has odometry; ``tests`` and ``followed`` are
    by the name of the recording.
    """

    name: str
    failure: str | None = None
    preprocessing_s: float | None = None
    mapping_s: float | None = None
    bytes: int | None = None
    notes: tuple[str, ...] = ()
    tests: Mapping[str, Answers] = field(default_factory=dict, repr=False)
    followed: Mapping[str, Answers] = field(default_factory=dict, repr=False)

    @property
    def learning_s(self) -> float | None:
        """Preprocessing and mapping together."""
        if self.preprocessing_s is None or self.mapping_s is None:
            return None
        return self.preprocessing_s + self.mapping_s

    def stored(self) -> dict[str, Any]:
        """Plain values with every answer, from which ``restored`` makes the same."""
        return {
            **{key: getattr(self, key) for key in ("name", "failure", "preprocessing_s", "mapping_s", "bytes")},
            "notes": list(self.notes),
            "tests": {name: answers.as_dict() for name, answers in self.tests.items()},
            "followed": {name: answers.as_dict() for name, answers in self.followed.items()},
        }

    @classmethod
    def restored(cls, values: Mapping[str, Any]) -> Self:
        """What ``stored`` made."""
        told = {
            key: {name: Answers.from_dict(one) for name, one in values[key].items()} for key in ("tests", "followed")
        }
        return cls(**{**values, "notes": tuple(values["notes"]), **told})

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: figures in place of answers."""
        keys = ("failure", "preprocessing_s", "mapping_s", "learning_s", "bytes")
        return {
            **{key: getattr(self, key) for key in keys},
            "notes": list(self.notes),
            "tests": {name: answers.figures().as_dict() for name, answers in self.tests.items()},
            "followed": {name: answers.figures().as_dict() for name, answers in self.followed.items()},
        }


@dataclass(frozen=True, eq=False)
class Comparison:
    """Methods in the order of tables on the same ``tests``; ``notes`` say what to keep in mind."""

    mapped: tuple[Recording, ...]
    tests: tuple[Recording, ...]
    positions: PoseSource
    entries: tuple[Entry, ...]
    hardware: Hardware
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "mapped": [one.name for one in self.mapped],
            "frames": sum(len(one.infos) for one in self.mapped),
            "tests": [one.name for one in self.tests],
            "positions": self.positions,
            "hardware": self.hardware.as_dict(),
            "methods": {one.name: one.as_dict() for one in self.entries},
            "notes": list(self.notes),
        }


def compare(
    recordings: Sequence[Recording],
    tests: Sequence[Recording],
    methods: Sequence[Method],
    *,
    positions: PoseSource = "reference",
    progress: Progress | None = None,
) -> Comparison:
    """Each method learns from all ``recordings`` and localizes every frame of every test.

    A method that fails is a row with its reason. Raises ``LeakageError`` for a test that is among the mapped drives or
    shares more than 5 % of its pictures with them, ``RecordingError`` for drives without positions, tests without
    truth, and tests that another camera took, and ``LearningError`` where no method succeeds.
    """
    check_split(recordings, tests, positions)
    entries = [enter(method, recordings, tests, positions=positions, progress=progress) for method in methods]
    require_success(entries)
    return Comparison(tuple(recordings), tuple(tests), positions, tuple(entries), Hardware.here())


def require_success(entries: Sequence[Entry]) -> None:
    """Raise ``LearningError`` where every method failed."""
    if all(one.failure is not None for one in entries):
        reasons = "; ".join(f"{one.name}: {one.failure}" for one in entries) or "none was given"
        raise LearningError(f"no method could be compared: {reasons}")


def enter(
    method: Method,
    recordings: Sequence[Recording],
    tests: Sequence[Recording],
    *,
    positions: PoseSource = "reference",
    progress: Progress | None = None,
) -> Entry:
    """One method on a split that ``check_split`` has passed."""

    def tell(stage: str, done: int, total: int) -> None:
        if progress is not None:
            progress(f"{method.name}: {stage}", done, total)

    try:
        learned = method.learn(recordings, positions=positions, progress=tell)
        single = {test.name: answers_of(learned.localizer, test, progress=tell) for test in tests}
        followed = {test.name: told for test in tests if (told := _followed(learned.localizer, test, tell)) is not None}
    except AndanteError as error:
        return Entry(method.name, failure=str(error))
    costs = (learned.preprocessing_s, learned.mapping_s, learned.bytes)
    entry = Entry(method.name, None, *costs, learned.notes, single, followed)
    return entry if positions == "reference" else _laid_over_truth(entry)


def _laid_over_truth(entry: Entry) -> Entry:
    """A method without a common frame with the truth, laid over it once, by its answers on all tests."""
    told = list(entry.tests.values())
    laid = fit_robustly(
        np.concatenate([one.xy for one in told]),
        np.concatenate([one.truth for one in told]),
        "the closer half of the answers themselves",
    )
    if laid is None:
        # Errors in a frame of their own would say nothing.
        failure = "its answers are too few, or all at one spot, to lay them over the truth"
        return Entry(entry.name, failure, notes=entry.notes)
    return replace(
        entry,
        notes=(*entry.notes, str(laid)),
        tests={name: one.laid_by(laid) for name, one in entry.tests.items()},
        followed={name: one.laid_by(laid) for name, one in entry.followed.items()},
    )


def _followed(localizer: StagedLocalizer[Any], test: Recording, progress: Progress) -> Answers | None:
    """What the particle filter makes of images and odometry; ``None`` for other methods, and without odometry."""
    has_odometry = any(info.odometry is not None for info in test.infos)
    if not isinstance(localizer, MapLocalizer) or localizer.name != OWN or not has_odometry:
        return None

    def tell(stage: str, done: int, total: int) -> None:
        progress(f"{stage}, followed", done, total)

    frames = run_tracker(make_tracker(localizer.slowmap), test, progress=tell).track.frames
    return Answers.of([frame.info for frame in frames], [frame.estimate for frame in frames])
