"""Threads that work ahead of one consumer: bounded, ordered, and gone when the consumer goes."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

from andante.data import ImageArray
from andante.errors import ConfigError, ImageError
from andante.recordings.decode import read_image

Item = TypeVar("Item")
Result = TypeVar("Result")

_LOOK_AHEAD = 4  # items per thread: enough to keep all busy, few enough to stay small in memory


def default_workers() -> int:
    """The processors of this machine, at most four: beyond that the consumer is the bottleneck."""
    return min(4, os.cpu_count() or 1)


def ordered_map(
    function: Callable[[Item], Result], items: Iterable[Item], workers: int | None = None
) -> Generator[Result, None, None]:
    """``map`` in threads: results in the order of ``items``, at most ``4 * workers`` of them held.

    An exception of ``function`` is raised when its turn comes. Closing the iterator early cancels what has
    not begun and waits for the at most ``workers`` calls under way. Raises ``ConfigError`` for ``workers`` < 1.
    """
    workers = default_workers() if workers is None else workers
    if workers < 1:
        raise ConfigError(f"workers = {workers} is not allowed; use 1 or more, or None for the default")
    return _run(function, items, workers)


def _run(function: Callable[[Item], Result], items: Iterable[Item], workers: int) -> Generator[Result, None, None]:
    pending: deque[Future[Result]] = deque()
    pool = ThreadPoolExecutor(workers, thread_name_prefix="andante-decode")
    try:
        for item in items:
            pending.append(pool.submit(function, item))
            if len(pending) >= _LOOK_AHEAD * workers:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def decode_ordered(
    paths: Iterable[str | Path], workers: int | None = None, *, colour: bool = False
) -> Generator[ImageArray | ImageError, None, None]:
    """Read image files in threads, in order; a file that cannot be read gives its ``ImageError`` as a value."""

    def read(path: str | Path) -> ImageArray | ImageError:
        try:
            return read_image(path, colour=colour)
        except ImageError as error:
            return error

    return ordered_map(read, paths, workers)
