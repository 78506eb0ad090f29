import random
import threading
import time

import numpy as np
import pytest

from andante.data import CameraSpec
from andante.errors import ConfigError, ImageError, RecordingError
from andante.recordings import MemoryRecording, iterate_frames, map_frames


class Faulty(MemoryRecording):
    """A recording some of whose pictures cannot be read."""

    def __init__(self, n, unreadable=(), sizes=None):
        super().__init__(
            [np.full((4, (sizes or {}).get(index, 6)), index % 256, np.uint8) for index in range(n)],
            range(n),
            CameraSpec(),
            name="monday",
        )
        self.unreadable = set(unreadable)
        self.loaded = []

    def load(self, info, *, colour=False):
        self.loaded.append(info.index)
        if info.index in self.unreadable:
            raise ImageError(f"{info.image} is broken")
        return super().load(info, colour=colour)


def indices_of(frames):
    return [frame.info.index for frame in frames]


def test_every_call_starts_again_and_two_can_run_side_by_side():
    recording = Faulty(20)
    assert indices_of(recording.frames()) == indices_of(recording.frames()) == list(range(20))
    pairs = list(zip(recording.frames(), recording.frames(range(20)), strict=True))
    assert all(a.info == b.info for a, b in pairs)


def test_frames_are_lazy():
    recording = Faulty(500)
    frames = recording.frames()
    assert recording.loaded == []
    next(frames)
    assert len(recording.loaded) < 50
    frames.close()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("andante-decode")]


def test_frames_and_results_stay_together_under_random_delays():
    delays = random.Random(0)

    def slow(frame):
        time.sleep(delays.uniform(0, 0.003))
        return int(frame.image[0, 0])

    results = list(map_frames(Faulty(60), slow, range(0, 60, 2), workers=5))
    assert [(info.index, value) for info, value in results] == [(i, i) for i in range(0, 60, 2)]


def test_function_runs_in_other_threads_and_on_skip_in_this_one():
    used, told = set(), set()
    recording = Faulty(40, unreadable=[7])
    list(
        map_frames(
            recording,
            lambda frame: used.add(threading.get_ident()),
            on_skip=lambda info, reason: told.add(threading.get_ident()),
        )
    )
    assert threading.get_ident() not in used
    assert told == {threading.get_ident()}


def test_unreadable_frames_are_skipped_and_told():
    told = []
    recording = Faulty(40, unreadable=[3, 17])
    frames = recording.frames(on_skip=lambda info, reason: told.append((info.index, reason)))
    assert indices_of(frames) == [index for index in range(40) if index not in (3, 17)]
    assert told == [(3, "image 3 is broken"), (17, "image 17 is broken")]


def test_an_image_error_of_the_function_skips_too():
    def picky(frame):
        if frame.info.index == 5:
            raise ImageError("no contrast")
        return frame.info.index

    told = []
    results = list(map_frames(Faulty(20), picky, on_skip=lambda info, reason: told.append(reason)))
    assert len(results) == 19
    assert told == ["no contrast"]


def test_another_error_of_the_function_passes_through():
    with pytest.raises(KeyError, match="mine"):
        list(map_frames(Faulty(5), lambda frame: {}["mine"]))


@pytest.mark.parametrize(("n", "allowed"), [(19, 0), (20, 1), (39, 1), (40, 2), (100, 5)])
def test_exactly_five_percent_may_be_skipped(n, allowed):
    assert len(list(Faulty(n, range(allowed)).frames())) == n - allowed
    with pytest.raises(RecordingError, match=f"at most 5% of {n} may be skipped"):
        list(Faulty(n, range(allowed + 1)).frames())


def test_too_many_skips_name_the_first_few_and_stop_at_once():
    recording = Faulty(1000, unreadable=range(100))
    with pytest.raises(
        RecordingError,
        match=r"recording 'monday': 51 of the first 51 images cannot be used, at most 5% of 1000 may be skipped: "
        r"image 0 is broken; image 1 is broken; image 2 is broken; \.\.\.",
    ):
        list(recording.frames())
    assert len(recording.loaded) < 100
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("andante-decode")]


def test_share_counts_what_was_asked_for():
    recording = Faulty(100, unreadable=[1])
    with pytest.raises(RecordingError, match="1 of the first 2 images"):
        list(recording.frames(range(10)))


def test_mixed_sizes_name_both_frames():
    recording = Faulty(10, sizes={6: 8})
    message = r"images of mixed size, image 0 is 6 x 4 and image 6 is 8 x 4 pixels; one recording needs one size"
    with pytest.raises(RecordingError, match=message):
        list(recording.frames())

    def strict_about_size(frame):
        if frame.image.shape[1] != 6:
            raise ValueError("a worse message")

    with pytest.raises(RecordingError, match=message):
        list(map_frames(recording, strict_about_size))


def test_indices_are_checked_before_anything_is_read():
    recording = Faulty(10)
    with pytest.raises(ConfigError, match="must ascend, got 2 after 5"):
        recording.frames([1, 5, 2])
    with pytest.raises(ConfigError, match="must ascend, got 1 after 1"):
        recording.frames([1, 1])
    with pytest.raises(ConfigError, match="frame 10 does not exist; this recording has frames 0 to 9"):
        recording.frames([3, 10])
    with pytest.raises(ConfigError, match="frame -1 does not exist"):
        recording.frames([-1, 3])
    assert list(recording.frames([])) == []
    assert indices_of(recording.frames(np.array([2, 4]))) == [2, 4]
    assert recording.loaded == [2, 4]


def test_colour_is_passed_on():
    assert next(iterate_frames(Faulty(1), colour=True)).image.shape == (4, 6, 3)
