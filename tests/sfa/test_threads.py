"""The limit on BLAS threads holds while anybody needs it and is gone afterwards."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from andante.sfa import one_thread


def blas_threads() -> set[int]:
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


def test_one_thread_inside_and_the_former_number_outside():
    before = blas_threads()
    with one_thread(), one_thread():
        assert blas_threads() == {1}
    assert blas_threads() == before


def test_an_error_inside_lifts_the_limit():
    before = blas_threads()
    with pytest.raises(RuntimeError), one_thread():
        raise RuntimeError
    assert blas_threads() == before


def test_overlapping_threads_leave_no_limit_behind():
    before = blas_threads()

    def work(seed: int) -> float:
        with one_thread():
            return float(np.linalg.norm(np.random.default_rng(seed).random((60, 60)) @ np.ones(60)))

    with ThreadPoolExecutor(8) as pool:
        assert len(list(pool.map(work, range(200)))) == 200
    assert blas_threads() == before
