"""Folders that teaching wrote, as labels of recordings: what a detector is learnt from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from andante.errors import InputError, RecordingError
from andante.landmarks.labels import Labels
from andante.protocols import Recording
from andante.recordings import open_recording

SUFFIX = ".landmarks"
"""Labels of the recording REC are beside it in REC.landmarks, where no other place was asked for."""


def beside(recording: Path) -> Path:
    """Where the labels of a recording go by default."""
    whole = recording.resolve()
    return whole.with_name(f"{whole.name}{SUFFIX}")


def read_lessons(folders: Sequence[Path], recordings: Sequence[Path] = ()) -> list[tuple[Recording, list[Labels]]]:
    """Every recording that was taught in, with all labels of it.

    A recording is looked for among ``recordings``, then beside the folder of its labels; the one of the same content is
    right, whatever it is called. Raises ``InputError`` for a folder without labels, labels of a recording that is not
    found, or a landmark that two files label in one recording; ``RecordingError`` as opening does.
    """
    known = {one.content_hash(): one for one in map(open_recording, recordings)}
    taught: dict[str, tuple[Recording, list[Labels]]] = {}
    for folder in folders:
        for labels in _labels_in(folder):
            recording = known.get(labels.content_hash or "") or _found_beside(folder, labels)
            content = recording.content_hash()
            known[content] = recording
            others = taught.setdefault(content, (recording, []))[1]
            if any(one.name == labels.name for one in others):
                raise InputError(
                    f"landmark {labels.name!r} of recording {labels.recording!r} has labels twice, in {folder} and "
                    "before; give one of them"
                )
            others.append(labels)
    return list(taught.values())


def _labels_in(folder: Path) -> list[Labels]:
    if not folder.is_dir():
        raise InputError(f"{folder} is no folder of labels; make one with: andante teach")
    files = sorted(folder.glob("*.json"))
    if not files:
        advice = f"give {beside(folder)}" if beside(folder).is_dir() else "make one with: andante teach"
        raise InputError(f"{folder} holds no labels (NAME.json); {advice}")
    return [Labels.load(file) for file in files]


def _found_beside(folder: Path, labels: Labels) -> Recording:
    """The recording that labels were made for."""
    for place in _places(folder, labels):
        try:
            recording = open_recording(place)
        except RecordingError:
            continue
        if labels.content_hash in (None, recording.content_hash()):
            return recording
    raise InputError(
        f"labels of {labels.name!r} in {folder} were made for recording {labels.recording!r}, which is not beside "
        "them with the same content; say where it is: --recordings REC"
    )


def _places(folder: Path, labels: Labels) -> Iterator[Path]:
    whole = folder.resolve()
    yield whole.parent / whole.name.removesuffix(SUFFIX)
    if Path(labels.recording).name == labels.recording:  # a name, and no path to somewhere else
        yield whole.parent / labels.recording
