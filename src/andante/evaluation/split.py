"""Whether what is learnt from and what is tested on are two things, and have what a comparison needs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from andante.data import PoseSource, Trajectory
from andante.errors import LeakageError, RecordingError
from andante.mapping.sessions import MAX_SHARED_PICTURES
from andante.protocols import Recording
from andante.recordings import map_frames, picture_fingerprint

_COLUMNS = {"reference": "x_m, y_m", "odometry": "odom_x_m, odom_y_m"}


def check_split(recordings: Sequence[Recording], tests: Sequence[Recording], positions: PoseSource) -> None:
    """Raise ``RecordingError`` or ``LeakageError`` where methods cannot learn from one and be compared on the other."""
    if not recordings or not tests:
        raise RecordingError(
            f"a comparison needs drives to learn from and drives to test on, got {len(recordings)} and {len(tests)}; "
            "name the others with --test"
        )
    twice = [name for name, count in Counter(one.name for one in tests).items() if count > 1]
    if twice:
        raise RecordingError(f"two test recordings are called {twice[0]!r}; tables tell them by name, so rename one")
    for recording in recordings:
        if not Trajectory.of(recording.infos, positions).known.any():
            raise RecordingError(
                f"recording {recording.name!r} has no {positions} positions ({_COLUMNS[positions]} of frames.csv are "
                "blank) to learn from; choose other --positions or fill them in"
            )
    for test in tests:
        _check_test(test, recordings[0])
    _check_leakage(recordings, tests)


def _check_test(test: Recording, mapped: Recording) -> None:
    if not Trajectory.of(test.infos, "reference").known.any():
        raise RecordingError(
            f"test recording {test.name!r} has no reference poses (x_m, y_m in frames.csv) to compare with"
        )
    if test.camera != mapped.camera:
        raise RecordingError(
            f"test recording {test.name!r} was taken by another camera than {mapped.name!r}; methods are compared on "
            "images of one camera: give both the same [camera] in recording.toml where it is the same"
        )


def _check_leakage(recordings: Sequence[Recording], tests: Sequence[Recording]) -> None:
    contents = {recording.content_hash(): recording.name for recording in recordings}
    mapped = np.unique(np.concatenate([_pictures(recording) for recording in recordings]))
    for test in tests:
        pictures = _pictures(test)
        shared = float(np.isin(pictures, mapped).mean()) if len(pictures) else 0.0
        name = contents.get(test.content_hash())
        if name is None and shared <= MAX_SHARED_PICTURES:
            continue
        what = f"is {name!r} itself" if name is not None else f"has {shared:.0%} of its pictures in common with those"
        raise LeakageError(
            f"test recording {test.name!r} {what}, which the methods learn from, so errors would look better than "
            "they are; test on another drive"
        )


def _pictures(recording: Recording) -> np.ndarray[tuple[int], np.dtype[np.str_]]:
    """Fingerprints of all pictures that can be read."""
    found = map_frames(recording, lambda frame: picture_fingerprint(frame.image))
    return np.array([fingerprint for _, fingerprint in found], dtype=np.str_)
