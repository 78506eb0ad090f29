"""Threads: one of BLAS for small problems, and a few of Python's for many of these at once."""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from typing import TypeVar

from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]

Item = TypeVar("Item")
Result = TypeVar("Result")

_MOST_WORKERS = 8
_lock = threading.Lock()
_users = 0
_limit: object = None


@cache
def _threadpools() -> ThreadpoolController:
    # Finding the libraries costs milliseconds, limiting them microseconds.
    return ThreadpoolController()


@contextmanager
def one_thread() -> Iterator[None]:
    """Inside, BLAS works in one thread; on a busy machine two wait for each other 10 times longer than they work.

    The limit belongs to the whole process. It is set by the first thread that comes in and lifted by the last one that
    leaves, so that threads which overlap do not leave it behind.
    """
    global _users, _limit  # noqa: PLW0603 (as the limit is of the process)
    with _lock:
        if _users == 0:
            _limit = _threadpools().limit(limits=1, user_api="blas")
        _users += 1
    try:
        yield
    finally:
        with _lock:
            _users -= 1
            if _users == 0:
                _limit.restore_original_limits()  # type: ignore[attr-defined]


def in_order(function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """``function`` of every item, worked on by as many threads as there are processors, in the order of the items.

    BLAS keeps to one thread meanwhile. No more than two items a thread are under way, so memory stays bounded.
    """
    workers = min(_MOST_WORKERS, os.cpu_count() or 1)
    waiting: deque[Future[Result]] = deque()
    with one_thread(), ThreadPoolExecutor(workers) as pool:
        try:
            for item in items:
                if len(waiting) == 2 * workers:
                    yield waiting.popleft().result()
                waiting.append(pool.submit(function, item))
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()
