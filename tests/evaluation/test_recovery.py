import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.data import Status
from andante.evaluation.recovery import LASTING_FRAMES, Recovery, frames_to_settle, recovery_of

STATUSES = {"o": Status.OK, "w": Status.OK, "d": Status.DEGRADED, "l": Status.LOST, "?": Status.OK}
ERRORS = {"o": 0.1, "w": 2.0, "d": 0.3, "l": 5.0, "?": np.nan}
LASTING = "o" * LASTING_FRAMES


def told(text):
    """o: ok and right, w: ok and wrong, d: degraded and right, l: lost, ?: no truth."""
    return recovery_of([STATUSES[letter] for letter in text], np.array([ERRORS[letter] for letter in text]))


@pytest.mark.parametrize(
    ("text", "lengths", "unrecovered"),
    [
        (LASTING, [0], 0),
        ("lll" + LASTING, [3], 0),
        ("ll" + "o" * (LASTING_FRAMES - 1) + "d" + LASTING, [2 + LASTING_FRAMES], 0),
        (LASTING + "ddd" + LASTING, [0], 0),
        (LASTING + "dlw" + LASTING, [0, 2], 0),
        (LASTING + "l" + LASTING + "www", [0, 1, 3], 1),
        ("llllo", [4], 0),
        ("dddd", [4], 1),
        ("?l?" + LASTING, [1], 0),
    ],
)
def test_by_hand(text, lengths, unrecovered):
    first = None if unrecovered and len(lengths) == 1 else lengths[0]
    assert told(text) == Recovery(
        outages=len(lengths), unrecovered=unrecovered, first=first, median=np.median(lengths), worst=max(lengths)
    )


@pytest.mark.parametrize("text", ["", "??"])
def test_without_truth_nothing_is_known(text):
    assert told(text) == Recovery(outages=0, unrecovered=0, first=None, median=None, worst=None)


@given(st.text("owdl", max_size=60))
def test_outages_are_no_longer_than_the_track_and_settled_tracks_have_one(text):
    found = told(text)
    assert (found.worst or 0) <= len(text)
    assert found.unrecovered <= min(found.outages, 1)
    if "w" not in text and "l" not in text:
        assert found.outages == (1 if text else 0)


@given(st.lists(st.booleans(), max_size=40), st.integers(0, 5))
def test_settling_against_a_slow_reference(settled, start):
    expected = None
    for at in range(start, len(settled)):
        after = settled[at : at + LASTING_FRAMES]
        if all(after) and len(after) in (LASTING_FRAMES, len(settled) - at):
            expected = at - start
            break
    assert frames_to_settle(np.array(settled, dtype=bool), start) == expected
