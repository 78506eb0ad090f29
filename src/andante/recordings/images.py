"""A plain folder of images, alone or beside a table in somebody else's words."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from andante.data import CameraSpec, FrameInfo
from andante.errors import ConfigError, RecordingError
from andante.recordings.decode import IMAGE_SUFFIXES
from andante.recordings.folder import FolderRecording
from andante.recordings.manifest import Manifest
from andante.recordings.table import COLUMNS, REQUIRED_COLUMNS, Table, frame_infos, parse_table, read_text

TimeUnit = Literal["s", "ms", "us", "ns"]
_TICKS_PER_SECOND: Mapping[str, float] = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}


def open_images(
    folder: str | Path,
    table: str | Path | None = None,
    *,
    columns: Mapping[str, str] | None = None,
    camera: CameraSpec | None = None,
    name: str | None = None,
    time_unit: TimeUnit = "s",
) -> FolderRecording:
    """Open a folder of images as a recording.

    Without ``table`` the images of the folder come in natural order (2 before 10), one second apart from zero.
    With it, ``columns`` maps our names (``timestamp_s``, ``image``, ``x_m``, ...) to its headers; by default it
    uses ours. Other columns are ignored; cells are parted by comma, semicolon, tab or spaces; images are
    relative to ``folder``. ``camera`` is an up-facing equidistant fisheye of 180 degrees where it is not given.
    Raises ``RecordingError``, and ``ConfigError`` for unknown names or units.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise RecordingError(f"folder of images {folder} does not exist or is no folder; check the path")
    if time_unit not in _TICKS_PER_SECOND:
        raise ConfigError(f"time unit {time_unit!r} is unknown; allowed are {', '.join(_TICKS_PER_SECOND)}")
    if columns is not None:
        _check_columns(columns)

    def read_infos() -> tuple[FrameInfo, ...]:
        if table is None:
            return _images_in_order(folder)
        sniffed = _parse_sniffed(read_text(Path(table)), str(table))
        known = {ours: ours for ours in COLUMNS if ours in sniffed.header} if columns is None else columns
        return frame_infos(sniffed, known, ticks_per_second=_TICKS_PER_SECOND[time_unit])

    manifest = Manifest(name or folder.resolve().name, camera or CameraSpec())
    return FolderRecording(folder, manifest, read_infos)


def _check_columns(columns: Mapping[str, str]) -> None:
    unknown = [name for name in columns if name not in COLUMNS]
    if unknown:
        raise ConfigError(f"columns: unknown name {unknown[0]!r}; allowed are {', '.join(COLUMNS)}")
    missing = [name for name in REQUIRED_COLUMNS if name not in columns]
    if missing:
        raise ConfigError(f"columns: {missing[0]!r} is missing; say which column of the table holds it")


def _images_in_order(folder: Path) -> tuple[FrameInfo, ...]:
    names = [
        path.name
        for path in folder.iterdir()
        if path.suffix.lower() in IMAGE_SUFFIXES and not path.name.startswith(".") and path.is_file()
    ]
    if not names:
        raise RecordingError(f"{folder} holds no images; looked for {', '.join(IMAGE_SUFFIXES)}")
    return tuple(FrameInfo(index, name, float(index)) for index, name in enumerate(sorted(names, key=_natural_key)))


def _natural_key(name: str) -> tuple[list[tuple[str, int]], str]:
    """Digits compare as numbers; the name itself decides between equals such as 1 and 01."""
    parts = re.findall(r"(\D*)(\d*)", name.lower())
    return [(text, int(digits or -1)) for text, digits in parts], name


def _parse_sniffed(text: str, source: str) -> Table:
    """Parse by the delimiter that the header line holds most of; runs of spaces count as one."""
    header = text.lstrip().split("\n", 1)[0]
    delimiter = max(",;\t", key=header.count)
    if delimiter in header:
        return parse_table(text, source, delimiter=delimiter)
    return parse_table("\n".join(" ".join(line.split()) for line in text.split("\n")), source, delimiter=" ")
