"""Frames of any recording, decoded and worked on in threads, with few unreadable ones forgiven."""

from __future__ import annotations

import operator
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass
from itertools import pairwise
from typing import Generic, TypeVar

from andante.data import Frame, FrameInfo
from andante.errors import ConfigError, ImageError, RecordingError
from andante.protocols import Recording, SkipCallback
from andante.recordings.parallel import ordered_map

MAX_SKIPPED_SHARE = 0.05
_NAMED_SKIPS = 3

Result = TypeVar("Result")


def iterate_frames(
    recording: Recording,
    indices: Sequence[int] | None = None,
    *,
    colour: bool = False,
    on_skip: SkipCallback | None = None,
    workers: int | None = None,
) -> Generator[Frame, None, None]:
    """Decode frames in order, as ``Recording.frames`` promises; raises as ``map_frames`` does."""

    def itself(frame: Frame) -> Frame:
        return frame

    pairs = map_frames(recording, itself, indices, colour=colour, on_skip=on_skip, workers=workers)
    return (frame for _, frame in pairs)


def map_frames(
    recording: Recording,
    function: Callable[[Frame], Result],
    indices: Sequence[int] | None = None,
    *,
    colour: bool = False,
    on_skip: SkipCallback | None = None,
    workers: int | None = None,
) -> Generator[tuple[FrameInfo, Result], None, None]:
    """Apply ``function`` to every frame in the threads that decode, and give the results in order.

    ``function`` must be safe to call from many threads. An ``ImageError`` from it or from decoding skips the
    frame; ``on_skip``, called in the thread of the consumer, is told. Raises ``RecordingError`` once more than
    5 % of the frames asked for are skipped and for pictures of mixed size, ``ConfigError`` for ``indices`` that
    are not ascending or outside of the recording; other exceptions of ``function`` pass through.
    """
    infos = _chosen(recording.infos, indices)

    def work(info: FrameInfo) -> _Outcome[Result]:
        return _attempt(recording, info, function, colour)

    return _without_skipped(recording.name, len(infos), ordered_map(work, infos, workers), on_skip)


@dataclass(frozen=True, slots=True)
class _Outcome(Generic[Result]):
    """What became of one frame: exactly one of ``results`` (one item) and ``error`` is set.

    Errors travel as values, so that the consumer can look at the size of a picture first: a function often
    fails on a picture of another size, and the size is then the better message.
    """

    info: FrameInfo
    size: str  # "width x height", empty where the picture could not be read
    results: tuple[Result, ...] = ()
    error: Exception | None = None


def _attempt(
    recording: Recording, info: FrameInfo, function: Callable[[Frame], Result], colour: bool
) -> _Outcome[Result]:
    size = ""
    try:
        image = recording.load(info, colour=colour)
        size = f"{image.shape[1]} x {image.shape[0]}"
        return _Outcome(info, size, (function(Frame(info, image)),))
    except Exception as error:  # not swallowed: the consumer raises it when its turn comes
        return _Outcome(info, size, error=error)


def _without_skipped(
    name: str, asked: int, outcomes: Generator[_Outcome[Result], None, None], on_skip: SkipCallback | None
) -> Generator[tuple[FrameInfo, Result], None, None]:
    first: _Outcome[Result] | None = None
    skipped: list[str] = []
    with closing(outcomes):  # an error here must stop the threads at once, not when its traceback is freed
        for seen, outcome in enumerate(outcomes, start=1):
            if outcome.size:
                first = first or outcome
                _check_size(name, first, outcome)
            if outcome.error is None:
                yield outcome.info, outcome.results[0]
            elif isinstance(outcome.error, ImageError):
                skipped.append(str(outcome.error))
                if on_skip is not None:
                    on_skip(outcome.info, skipped[-1])
                _check_skipped(name, skipped, seen, asked)
            else:
                raise outcome.error


def _check_size(name: str, first: _Outcome[Result], outcome: _Outcome[Result]) -> None:
    if outcome.size != first.size:
        raise RecordingError(
            f"recording {name!r}: images of mixed size, {first.info.image} is {first.size} and "
            f"{outcome.info.image} is {outcome.size} pixels; one recording needs one size"
        )


def _check_skipped(name: str, skipped: list[str], seen: int, asked: int) -> None:
    if len(skipped) > MAX_SKIPPED_SHARE * asked:
        more = "; ..." if len(skipped) > _NAMED_SKIPS else ""
        raise RecordingError(
            f"recording {name!r}: {len(skipped)} of the first {seen} images cannot be used, at most "
            f"{MAX_SKIPPED_SHARE:.0%} of {asked} may be skipped: {'; '.join(skipped[:_NAMED_SKIPS])}{more}"
        )


def _chosen(infos: Sequence[FrameInfo], indices: Sequence[int] | None) -> Sequence[FrameInfo]:
    if indices is None:
        return infos
    wanted = [operator.index(index) for index in indices]
    for before, after in pairwise(wanted):
        if after <= before:
            raise ConfigError(f"indices of frames must ascend, got {after} after {before}; sort them and drop doubles")
    if wanted and (wanted[0] < 0 or wanted[-1] >= len(infos)):
        wrong = wanted[0] if wanted[0] < 0 else wanted[-1]
        raise ConfigError(f"frame {wrong} does not exist; this recording has frames 0 to {len(infos) - 1}")
    return [infos[index] for index in wanted]
