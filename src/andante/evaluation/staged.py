"""A recording through one localizer, image by image in one thread, with every step timed apart (thesis table 8.3)."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import cv2
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]

from andante.baselines import StagedLocalizer
from andante.data import Estimate
from andante.errors import ImageError, RecordingError
from andante.evaluation.answers import Answers
from andante.mapping import Progress
from andante.protocols import Recording
from andante.recordings.frames import MAX_SKIPPED_SHARE


def answers_of(localizer: StagedLocalizer[Any], recording: Recording, *, progress: Progress | None = None) -> Answers:
    """Decode, prepare and locate every frame, which is told with the seconds of each.

    Frames that cannot be read are left out; more than 5 % of them raise ``RecordingError``.
    """
    infos, estimates, seconds = [], list[Estimate](), list[tuple[float, float, float]]()
    unread: list[str] = []
    with one_core():
        for done, info in enumerate(recording.infos, start=1):
            start = time.perf_counter()
            try:
                image = recording.load(info)
                decoded = time.perf_counter()
                prepared = localizer.prepare(image)
            except ImageError as error:
                unread.append(str(error))
                continue
            ready = time.perf_counter()
            estimates.append(localizer.locate(prepared))
            infos.append(info)
            seconds.append((decoded - start, ready - decoded, time.perf_counter() - ready))
            if progress is not None:
                progress(recording.name, done, len(recording.infos))
    if len(unread) > MAX_SKIPPED_SHARE * len(recording.infos):
        raise RecordingError(
            f"recording {recording.name!r}: {len(unread)} of {len(recording.infos)} images cannot be used, the first "
            f"one because: {unread[0]}"
        )
    return Answers.of(infos, estimates, seconds)


@contextmanager
def one_core() -> Iterator[None]:
    """Inside, the threads of BLAS, OpenMP (PyTorch's among them) and OpenCV are one each."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        with threadpool_limits(limits=1):
            yield
    finally:
        cv2.setNumThreads(threads)
