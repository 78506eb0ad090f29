"""One trial: a localizer learns from some drives and is tested on another. What is finished is not done again."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from andante.data import FloatArray
from andante.evaluation.experiments.cache import ResultStore, code_hash, rendered
from andante.evaluation.experiments.contenders import Contender
from andante.evaluation.experiments.drives import EncodedDrive, encode, front_end_of
from andante.mapping import FrontEnd, MapConfig, Progress
from andante.recordings import FolderRecording
from andante.sfa import one_thread
from andante.simulator import Plan

Task = TypeVar("Task")
Done = TypeVar("Done")

_DECIMALS = 4  # a tenth of a millimetre


@dataclass(frozen=True)
class Drive:
    """A session of the plan, or the frames of it with these ascending ``indices``."""

    session: str
    indices: tuple[int, ...] | None = None


@dataclass(frozen=True)
class Trial:
    """``contender`` learns from ``train``, in this order, and says where the frames of ``test`` are."""

    contender: Contender
    train: tuple[Drive, ...]
    test: Drive


@dataclass(frozen=True, eq=False)
class Result:
    """Estimates ``xy`` (n, 2) and ``truth`` (n, 2) in metres, seconds of learning, bytes of what was learnt."""

    xy: FloatArray
    truth: FloatArray
    seconds: float
    bytes: int

    @property
    def errors(self) -> FloatArray:
        """(n,) metres, of the best hypothesis of every frame."""
        errors: FloatArray = np.linalg.norm(self.xy - self.truth, axis=1)
        return errors


class Bench:
    """Runs trials on the sessions of one plan, with everything that can be used again in ``cache``.

    Sessions are rendered, and drives encoded, only when the first unfinished trial needs them.
    """

    def __init__(self, plan: Plan, cache: Path, *, workers: int = 1, progress: Progress | None = None) -> None:
        self.plan, self.store = plan, ResultStore(cache)
        self.cache, self.workers = cache, workers
        self.progress: Progress = progress or (lambda stage, done, total: None)
        self._recordings: dict[str, FolderRecording] = {}
        self._front_ends: dict[str, FrontEnd] = {}
        self._encoded: dict[tuple[str, str], EncodedDrive] = {}

    def beside(self, plan: Plan) -> Bench:
        """Another plan in the same cache."""
        return Bench(plan, self.cache, workers=self.workers, progress=self.progress)

    def spread(self, function: Callable[[Task], Done], tasks: Sequence[Task]) -> Iterator[Done]:
        """``function``, which a module has at its top, of every task, in order, in as many processes as may be."""
        if self.workers == 1:
            yield from map(function, tasks)
            return
        with ProcessPoolExecutor(self.workers, get_context("spawn")) as pool:
            yield from pool.map(function, tasks, chunksize=8)

    def run(self, trials: Sequence[Trial]) -> list[Result]:
        """The results of all trials, in order; a killed run goes on after its last finished trial."""
        results = []
        for done, trial in enumerate(trials):
            self.progress("trials", done, len(trials))
            results.append(self._result(trial))
        self.progress("trials", len(trials), len(trials))
        return results

    def _result(self, trial: Trial) -> Result:
        key = self._key(trial)
        stored = self.store.load(key)
        if stored is None:
            stored = self._computed(trial)
            self.store.save(key, stored)
        return Result(
            xy=np.array(stored["xy"], dtype=np.float64),
            truth=np.array(stored["truth"], dtype=np.float64),
            seconds=stored["seconds"],
            bytes=stored["bytes"],
        )

    def _key(self, trial: Trial) -> dict[str, Any]:
        """All that the result depends on: pictures, configuration, and the code that makes one of the other."""

        def named(drive: Drive) -> list[Any]:
            return [self.plan.fingerprint(drive.session), None if drive.indices is None else list(drive.indices)]

        return {
            "contender": trial.contender.key,
            "train": [named(drive) for drive in trial.train],
            "test": named(trial.test),
            "code": code_hash(),
        }

    def _computed(self, trial: Trial) -> dict[str, Any]:
        config = trial.contender.config
        train, test = [self.drive(drive, config) for drive in trial.train], self.drive(trial.test, config)
        start = time.perf_counter()
        fitted = trial.contender.fit(self.front_end(config), train, config)
        seconds = time.perf_counter() - start
        with one_thread():
            xy = fitted.locate(test)
        return {
            "xy": np.round(xy, _DECIMALS).tolist(),
            "truth": np.round(test.xy, _DECIMALS).tolist(),
            "seconds": seconds,
            "bytes": fitted.bytes,
        }

    def drive(self, drive: Drive, config: MapConfig) -> EncodedDrive:
        """A drive through the front end of a configuration, encoded once."""
        key = _eye(config), drive.session
        if key not in self._encoded:
            recording = self.recording(drive.session)
            self._encoded[key] = encode(recording, self.front_end(config), config, self.progress)
        whole = self._encoded[key]
        return whole if drive.indices is None else whole.part(drive.indices)

    def front_end(self, config: MapConfig) -> FrontEnd:
        """One for all sessions of a plan, which has one camera."""
        if _eye(config) not in self._front_ends:
            self._front_ends[_eye(config)] = front_end_of(self.recording(self.plan.sessions[0].name), config)
        return self._front_ends[_eye(config)]

    def recording(self, session: str) -> FolderRecording:
        """A session of the plan, rendered where it was not yet."""
        if not self._recordings:
            self._recordings = rendered(self.plan, self.cache, workers=self.workers, progress=self.progress)
        return self._recordings[session]


def _eye(config: MapConfig) -> str:
    """What decides the features of a picture, as text."""
    return json.dumps([config.panorama.model_dump(), config.features.model_dump()])
