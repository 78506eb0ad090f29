"""One BLAS thread for small problems, from any number of Python threads at once."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]

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
