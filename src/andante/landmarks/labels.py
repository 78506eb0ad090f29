"""Where one landmark is in the frames of one recording, as a human and an anchor taught it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from andante.errors import InputError
from andante.files import replace_file
from andante.landmarks.boxes import Box
from andante.protocols import Recording

SCHEMA = 1
MAX_BYTES = 2**26
"""A file of labels that is larger is not read: 500 labels take 60 kB."""

_NAME = re.compile(r"[^\W_][\w .-]{0,99}")
_MOST_NAME_BYTES = 200
"""Files are called like their landmarks, and a file system that takes 255 bytes needs some for what it adds."""
_Angle = Annotated[float, Field(ge=-math.pi, le=math.pi)]
_Width = Annotated[float, Field(gt=0, le=2 * math.pi)]
_Height = Annotated[float, Field(gt=0, le=math.pi)]


@dataclass(frozen=True, slots=True)
class Labels:
    """Boxes of the landmark ``name`` by frame index, and the frames in which it is ``absent`` for certain.

    Of a frame in neither, nothing is known: where the anchor was not found, the landmark may still be in view. So such
    a frame teaches a detector nothing about this landmark, neither that it is there nor that it is not.
    ``content_hash`` is that of the recording, so that labels are not used with another one. ``anchors`` are the boxes
    of the thing that stood beside the landmark while it was taught, by frame: it will be gone, so a detector must not
    learn that it belongs there.
    Raises ``InputError`` for an unusable name, a box that no picture can have, a frame both labelled and absent.
    """

    name: str
    recording: str
    boxes: Mapping[int, Box]
    absent: frozenset[int] = frozenset()
    content_hash: str | None = None
    anchors: Mapping[int, Box] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_name(self.name)
        for frame, box in (*self.boxes.items(), *self.anchors.items()):
            _check_frame(self.name, frame)
            _check_box(self.name, frame, box)
        for frame in self.absent:
            _check_frame(self.name, frame)
        if both := sorted(self.absent & self.boxes.keys()):
            raise InputError(
                f"labels of {self.name!r}: frame {both[0]} has a box and is declared absent as well; keep one of them"
            )

    @property
    def frames(self) -> list[int]:
        """Frames of which something is known, in order."""
        return sorted(self.boxes.keys() | self.absent)

    def save(self, path: str | Path) -> None:
        """Write as JSON, all or nothing; raises ``InputError`` where the place cannot be written."""
        values = {
            "schema": SCHEMA,
            "name": self.name,
            "recording": self.recording,
            "content_hash": self.content_hash,
            "boxes": _rows(self.boxes),
            "absent": sorted(self.absent),
            "anchors": _rows(self.anchors),
        }
        text = _LabelsFile.model_validate(values).model_dump_json(by_alias=True, indent=1)
        write_file(Path(path), text.encode())

    @classmethod
    def load(cls, path: str | Path) -> Labels:
        """Read what ``save`` wrote; raises ``InputError`` naming the file and what is wrong with it."""
        text = read_file(Path(path), MAX_BYTES)
        try:
            file = _LabelsFile.model_validate_json(text)
        except ValidationError as error:
            raise InputError(f"labels {path} cannot be used: {_first_fault(error)}") from None
        frames = [row.frame for row in file.boxes]
        if len(set(frames)) < len(frames):
            twice = next(frame for frame in frames if frames.count(frame) > 1)
            raise InputError(f"labels {path}: frame {twice} has two boxes; a landmark is in a frame once")
        boxes, anchors = ({row.frame: row.box for row in rows} for rows in (file.boxes, file.anchors))
        try:
            return cls(file.name, file.recording, boxes, frozenset(file.absent), file.content_hash, anchors)
        except InputError as error:
            raise InputError(f"labels {path} cannot be used: {error}") from None


def check_name(name: str) -> None:
    """Raise ``InputError`` for a name that is empty, or that could be taken for a path in a file system."""
    if not _NAME.fullmatch(name) or len(name.encode()) > _MOST_NAME_BYTES:
        raise InputError(
            f"a landmark cannot be called {name[:80]!r}; allowed are 1 to 100 letters, digits, spaces, dots, "
            f"underscores and hyphens, {_MOST_NAME_BYTES} bytes at most, beginning with a letter or digit"
        )


def require_usable(labels: Labels, recording: Recording, min_deg: float, max_deg: float, *, least: int = 1) -> None:
    """Raise ``InputError`` where labels do not belong to this recording or no detector can learn from them.

    ``min_deg`` and ``max_deg`` bound the elevations that are looked at; a box wholly outside of them is never seen.
    ``least`` is how many boxes there must be.
    """
    if labels.content_hash is not None and labels.content_hash != recording.content_hash():
        raise InputError(
            f"labels of {labels.name!r} were made for recording {labels.recording!r} of other content than "
            f"{recording.name!r}; give the recording that they were made for"
        )
    if len(labels.boxes) < least:
        raise InputError(
            f"landmark {labels.name!r} has {len(labels.boxes)} labels in {labels.recording!r}, at least {least} are "
            "needed; drive past the anchor more often or bring it closer"
        )
    if labels.frames[-1] >= len(recording.infos):
        raise InputError(
            f"labels of {labels.name!r} speak of frame {labels.frames[-1]}, recording {recording.name!r} has frames "
            f"0 to {len(recording.infos) - 1}; give the recording that they were made for"
        )
    for frame, box in sorted(labels.boxes.items()):
        low, high = np.degrees(box.low_rad), np.degrees(box.high_rad)
        if high <= min_deg or low >= max_deg:
            raise InputError(
                f"landmark {labels.name!r}: the box of frame {frame} lies at {low:.1f} to "
                f"{high:.1f} degrees of elevation, outside of the panorama with {min_deg:g} to "
                f"{max_deg:g}; teach it nearer to the horizon"
            )


def read_file(path: Path, most_bytes: int) -> bytes:
    """All of a small file; raises ``InputError`` where it cannot be read or is not small."""
    try:
        size = path.stat().st_size
        if size > most_bytes:
            raise InputError(f"{path} has {size:,} bytes, at most {most_bytes:,} are read; is it the right file?")
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}; check the path") from None


def write_file(path: Path, data: bytes) -> None:
    """Write a file whole or not at all; raises ``InputError`` where its place cannot be written."""
    try:
        replace_file(path, data)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror}; choose another place") from None


class _Row(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    frame: Annotated[int, Field(ge=0)]
    azimuth_rad: _Angle
    elevation_rad: _Angle
    width_rad: _Width
    height_rad: _Height

    @property
    def box(self) -> Box:
        return Box(self.azimuth_rad, self.elevation_rad, self.width_rad, self.height_rad)


class _LabelsFile(BaseModel):
    model_config = ConfigDict(extra="forbid")

    format: Literal["andante landmark labels"] = "andante landmark labels"
    version: Annotated[Literal[1], Field(alias="schema")] = 1
    name: str
    recording: str
    content_hash: str | None
    boxes: list[_Row]
    absent: list[Annotated[int, Field(ge=0)]]
    anchors: list[_Row] = []


def _rows(boxes: Mapping[int, Box]) -> list[dict[str, Any]]:
    return [{"frame": frame, **asdict(boxes[frame])} for frame in sorted(boxes)]


def _first_fault(error: ValidationError) -> str:
    fault: Any = error.errors(include_url=False)[0]
    where = ".".join(str(part) for part in fault["loc"])
    if where == "schema":
        return f"they have schema {fault['input']!r:.20}, this version of andante reads {SCHEMA}; upgrade andante"
    told = f"{where}: {fault['msg'].lower()}" if where else str(fault["msg"]).lower()
    return f"{told}; teach the landmark again"


def _check_frame(name: str, frame: int) -> None:
    if frame < 0:
        raise InputError(f"labels of {name!r}: frame {frame} does not exist; frames are numbered from 0")


def _check_box(name: str, frame: int, box: Box) -> None:
    numbers = box.azimuth_rad, box.elevation_rad, box.width_rad, box.height_rad
    usual = (
        all(map(math.isfinite, numbers))
        and abs(box.azimuth_rad) <= math.pi
        and abs(box.elevation_rad) <= math.pi / 2.0
        and 0.0 < box.width_rad <= 2.0 * math.pi
        and 0.0 < box.height_rad <= math.pi
    )
    if not usual:
        raise InputError(
            f"labels of {name!r}: frame {frame} has a box with azimuth, elevation, width and height "
            f"{', '.join(f'{number:.3g}' for number in numbers)} rad; allowed are azimuths from -pi to pi, elevations "
            "from -pi/2 to pi/2, widths up to 2 pi and heights up to pi"
        )


def names_of(labels: Iterable[Labels]) -> list[str]:
    """The landmarks that labels speak of, each once, in the order in which they first come."""
    return list(dict.fromkeys(one.name for one in labels))
