"""Recordings whose pictures are files: the project's own folder format, and what other openers build on."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from andante.data import CameraSpec, Frame, FrameInfo, ImageArray
from andante.errors import RecordingError
from andante.protocols import SkipCallback
from andante.recordings.content import hash_content
from andante.recordings.decode import read_image
from andante.recordings.frames import iterate_frames
from andante.recordings.manifest import Manifest, parse_manifest
from andante.recordings.table import frame_infos, own_columns, parse_table, read_text

MANIFEST = "recording.toml"
TABLE = "frames.csv"


class FolderRecording:
    """A ``Recording`` of image files below one folder.

    ``read_infos`` gives the frames; it is called once, when they are first needed, and may raise ``RecordingError``.
    """

    def __init__(self, folder: Path, manifest: Manifest, read_infos: Callable[[], tuple[FrameInfo, ...]]) -> None:
        self.folder = folder
        self._manifest = manifest
        self._read_infos = read_infos
        self._real_folder = os.path.realpath(folder)

    def __repr__(self) -> str:
        return f"FolderRecording({str(self.folder)!r})"

    @property
    def name(self) -> str:
        """A short name for people."""
        return self._manifest.name

    @property
    def camera(self) -> CameraSpec:
        """The camera that took all frames."""
        return self._manifest.camera

    @property
    def conditions(self) -> Mapping[str, Any]:
        """Free keys: season, weather, time of day."""
        return self._manifest.conditions

    @cached_property
    def infos(self) -> Sequence[FrameInfo]:
        """What is known of every frame; raises ``RecordingError`` for a faulty table."""
        return self._read_infos()

    def load(self, info: FrameInfo, *, colour: bool = False) -> ImageArray:
        """Read one picture; raises ``ImageError``, or ``RecordingError`` for a link that leads out of the folder."""
        return read_image(self._picture_path(info), colour=colour)

    def frames(
        self,
        indices: Sequence[int] | None = None,
        *,
        colour: bool = False,
        on_skip: SkipCallback | None = None,
    ) -> Iterator[Frame]:
        """Decode frames lazily, in order; every call starts again. Raises as ``map_frames`` does."""
        return iterate_frames(self, indices, colour=colour, on_skip=on_skip)

    def content_hash(self) -> str:
        """SHA-256 over the table and the bytes of the image files; a missing file counts as no picture."""
        return hash_content(self.infos, self._picture_bytes())

    def _picture_bytes(self) -> Generator[bytes | None, None, None]:
        for info in self.infos:
            try:
                yield self._picture_path(info).read_bytes()
            except OSError:
                yield None

    def _picture_path(self, info: FrameInfo) -> Path:
        path = os.path.realpath(self.folder / info.image)
        if not path.startswith(self._real_folder + os.sep):
            raise RecordingError(
                f"recording {self.name!r}: image {info.image} is a link out of the folder {self.folder}; "
                f"copy the file into the recording"
            )
        return self.folder / info.image


def open_folder(folder: str | Path) -> FolderRecording:
    """Open ``recording.toml``, ``frames.csv`` and ``images/``; raises ``RecordingError`` for what is missing.

    The table is read when it is first needed.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise RecordingError(f"recording {folder} does not exist or is no folder; check the path")
    for name in (MANIFEST, TABLE):
        if not (folder / name).is_file():
            raise RecordingError(
                f"recording {folder}: {name} is missing; a recording is a folder with {MANIFEST}, {TABLE} and "
                'its images. For a plain folder of images ask for format="images" in Python'
            )
    path = folder / MANIFEST
    return FolderRecording(folder, parse_manifest(read_text(path), str(path)), lambda: _read_table(folder / TABLE))


def _read_table(path: Path) -> tuple[FrameInfo, ...]:
    table = parse_table(read_text(path), str(path))
    return frame_infos(table, own_columns(table))
