"""What is remembered of drives: bounded, whole again after a file, and every frame with what belongs to it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.mapping.codes import Codes
from andante.mapping.memory import MappedSession, Source, bounded, memory_arrays, memory_of, rows_of


def session(n: int, number: int = 0, step_m: float = 0.2) -> MappedSession:
    """A straight drive; codes, phases, number and fingerprint of a frame all tell which it is."""
    frame = np.arange(n)
    marks = np.column_stack([frame + 1, np.full(n, 1000.0 * (number + 1))]).astype(np.float32)
    xy = np.column_stack([step_m * frame, np.full(n, 0.01 * number)])
    source = Source(f"day {number}", f"hash {number}", n, "reference", {"light": number}, folder="/somewhere")
    return MappedSession(
        source,
        Codes.of(marks),
        Codes.of(-marks[:, :1]),
        xy,
        xy[:, 0] / 9,
        3 * frame,
        (frame + 5000 * number).astype(np.uint32),
    )


def same(one: MappedSession, other: MappedSession) -> None:
    assert one.source == other.source
    for name in ("xy", "heading_rad", "number", "pictures"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for mine, theirs in ((one.codes, other.codes), (one.phase, other.phase)):
        np.testing.assert_array_equal(mine.codes, theirs.codes)
        np.testing.assert_array_equal(mine.scale, theirs.scale)


def test_a_subset_keeps_together_what_belongs_together():
    whole = session(20, 2)
    chosen = np.array([3, 4, 11])
    part = whole.subset(chosen)
    assert (len(part), part.source.frames, len(part.codes)) == (3, 3, 3)
    assert (part.source.name, part.source.content_hash, part.source.folder) == ("day 2", "hash 2", "/somewhere")
    np.testing.assert_array_equal(part.number, [9, 12, 33])
    np.testing.assert_array_equal(part.pictures, 10_000 + chosen)
    np.testing.assert_array_equal(part.codes.rows(), whole.codes.rows()[chosen])
    np.testing.assert_array_equal(part.phase.rows(), whole.phase.rows()[chosen])
    same(whole.subset(np.isin(np.arange(20), chosen)), part)


@given(st.lists(st.integers(1, 60), min_size=1, max_size=6), st.integers(1, 200))
def test_no_more_frames_than_asked_for_and_each_unchanged(lengths, at_most):
    sessions = [session(n, number) for number, n in enumerate(lengths)]
    kept = bounded(sessions, at_most)
    assert sum(map(len, kept)) == min(sum(lengths), sum(map(len, kept))) <= max(at_most, 0)
    assert all(len(part) for part in kept)
    by_name = {whole.source.name: whole for whole in sessions}
    assert [part.source.name for part in kept] == [name for name in by_name if name in {p.source.name for p in kept}]
    for part in kept:
        assert part.source.frames == len(part)
        same(part, by_name[part.source.name].subset(part.number // 3))
    if sum(lengths) <= at_most:
        assert [part is whole for part, whole in zip(kept, sessions, strict=True)] == [True] * len(lengths)
    if at_most >= len(lengths):
        assert len(kept) == len(lengths)  # no session is forgotten where one frame of each is allowed


@pytest.mark.parametrize("at_most", [100, 150, 400])
def test_every_session_keeps_all_its_places_as_far_as_possible(at_most):
    """A long drive does not push a short one out, and gaps grow no longer than they have to."""
    sessions = [session(300, 0, 0.1), session(40, 1, 0.75), session(300, 2, 0.1)]
    kept = bounded(sessions, at_most)
    assert [part.source.name for part in kept] == ["day 0", "day 1", "day 2"]
    assert 0.5 * at_most < sum(map(len, kept)) <= at_most
    fair = 3 * 30 / at_most  # metres between frames if all of them shared the bound
    for part, whole in zip(kept, sessions, strict=True):
        gaps = np.diff(part.xy[:, 0], prepend=whole.xy[0, 0], append=whole.xy[-1, 0])
        assert gaps.max() <= max(2.5 * fair, 0.75 + 1e-9) + 0.75 * (len(whole) == 40)


@given(st.lists(st.integers(0, 50), min_size=1, max_size=8))
def test_rows_of_sources_lie_one_after_the_other(frames):
    sources = [Source("a", "b", count, "reference") for count in frames]
    rows = rows_of(sources)
    covered = np.concatenate([np.arange(sum(frames))[part] for part in rows])
    np.testing.assert_array_equal(covered, np.arange(sum(frames)))
    assert [part.stop - part.start for part in rows] == frames


def test_no_sources_have_no_rows():
    assert rows_of([]) == []


@given(st.lists(st.integers(0, 9), min_size=1, max_size=5))
def test_arrays_hold_everything_that_sources_and_pictures_do_not(lengths):
    sessions = [session(n, number) for number, n in enumerate(lengths)]
    sources, pictures = [one.source for one in sessions], [one.pictures for one in sessions]
    again = memory_of(memory_arrays(sessions), sources, pictures)
    assert len(again) == len(sessions)
    for one, other in zip(sessions, again, strict=True):
        same(one, other)
