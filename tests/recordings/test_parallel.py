import threading
import time

import cv2
import numpy as np
import pytest

from andante.errors import ConfigError, ImageError
from andante.recordings import decode_ordered, default_workers, ordered_map


def decode_threads():
    return [thread for thread in threading.enumerate() if thread.name.startswith("andante-decode")]


def test_order_is_kept_under_random_delays():
    delays = np.random.default_rng(0).uniform(0, 0.004, 100)

    def slow(index):
        time.sleep(delays[index])
        return index

    assert list(ordered_map(slow, range(100), workers=7)) == list(range(100))


@pytest.mark.parametrize("workers", [1, 3])
def test_look_ahead_is_bounded(workers):
    begun = []
    results = ordered_map(begun.append, range(1000), workers)
    for taken in range(1, 21):
        next(results)
        assert len(begun) <= taken + 4 * workers
    results.close()
    assert len(begun) <= 20 + 4 * workers


def test_items_are_drawn_lazily():
    results = ordered_map(str, iter(range(10**12)), workers=2)
    assert [next(results) for _ in range(3)] == ["0", "1", "2"]
    results.close()


def test_nothing_runs_before_the_first_item_is_asked_for():
    begun = []
    results = ordered_map(begun.append, range(10), workers=2)
    results.close()
    assert begun == []
    assert decode_threads() == []


def test_closing_early_leaves_no_thread():
    results = ordered_map(lambda index: time.sleep(0.002), range(1000), workers=4)
    next(results)
    assert decode_threads()
    results.close()
    assert decode_threads() == []


def test_an_exception_comes_in_its_turn_and_leaves_no_thread():
    results = ordered_map(lambda index: 1 // (index - 5), range(100), workers=3)
    assert [next(results) for _ in range(5)] == [-1] * 5
    with pytest.raises(ZeroDivisionError):
        next(results)
    assert decode_threads() == []


def test_workers_must_be_positive():
    with pytest.raises(ConfigError, match="workers = 0 is not allowed; use 1 or more"):
        ordered_map(str, [1], workers=0)
    assert 1 <= default_workers() <= 4


def test_decode_ordered_gives_errors_as_values(tmp_path):
    for index in (0, 2):
        cv2.imwrite(str(tmp_path / f"{index}.png"), np.full((4, 5), index, np.uint8))
    first, second, third = decode_ordered([tmp_path / f"{index}.png" for index in range(3)], colour=True)
    assert first.shape == third.shape == (4, 5, 3)
    assert third[0, 0, 0] == 2
    assert isinstance(second, ImageError)
