"""Writes the folder format: as a stream, and all or nothing."""

from __future__ import annotations

import csv
import io
import shutil
import uuid
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal

import cv2

from andante.data import CameraSpec, Frame, FrameInfo, ImageArray, Pose2D
from andante.errors import ConfigError, RecordingError
from andante.recordings.decode import is_picture
from andante.recordings.folder import MANIFEST, TABLE, FolderRecording, open_folder
from andante.recordings.manifest import Manifest, Source, format_manifest, parse_manifest
from andante.recordings.table import COLUMNS, frame_infos, own_columns, parse_table

ImageFormat = Literal["jpg", "png"]


def write_recording(
    folder: str | Path,
    frames: Iterable[Frame],
    *,
    name: str,
    camera: CameraSpec,
    conditions: Mapping[str, Any] | None = None,
    source: Source | None = None,
    image_format: ImageFormat = "jpg",
    jpeg_quality: int = 95,
) -> FolderRecording:
    """Write frames as they come to a new folder and open it; ``folder`` appears only when it is complete.

    Pictures are numbered anew, so the names and indices in ``frames`` do not matter. Numbers are written such
    that they read back exactly; PNG does so for pictures too. Raises ``RecordingError`` for a folder that exists
    and for frames or conditions that could not be read back, ``ConfigError`` for an unknown image format.
    """
    folder = Path(folder)
    if folder.exists():
        raise RecordingError(f"{folder} exists already; choose another folder or remove it first")
    if image_format not in ("jpg", "png"):
        raise ConfigError(f"image format {image_format!r} is unknown; allowed are jpg, png")
    if not 1 <= jpeg_quality <= 100:
        raise ConfigError(f"jpeg_quality = {jpeg_quality} is not allowed; use 1 to 100")
    manifest = format_manifest(Manifest(name, camera, conditions or {}, source))
    parse_manifest(manifest, str(folder / MANIFEST))  # what could not be read must not be written

    part = folder.parent / f".{folder.name}.{uuid.uuid4().hex}.part"
    (part / "images").mkdir(parents=True)
    try:
        settings = [cv2.IMWRITE_JPEG_QUALITY, jpeg_quality] if image_format == "jpg" else []
        table = _write_images(part, frames, image_format, settings)
        parsed = parse_table(table, str(folder / TABLE))
        frame_infos(parsed, own_columns(parsed))
        (part / TABLE).write_text(table, encoding="utf-8", newline="")
        (part / MANIFEST).write_text(manifest, encoding="utf-8", newline="")
        part.rename(folder)
    except BaseException:  # an interrupt too must leave nothing behind
        shutil.rmtree(part, ignore_errors=True)
        raise
    return open_folder(folder)


def _write_images(part: Path, frames: Iterable[Frame], suffix: str, settings: list[int]) -> str:
    """Write every picture below ``part`` and return the text of the table."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(COLUMNS)
    for index, frame in enumerate(frames):
        image = f"images/{index:06d}.{suffix}"
        (part / image).write_bytes(_encode(frame.image, suffix, settings))
        rows.writerow(_row(frame.info, image))
    return text.getvalue()


def _encode(image: ImageArray, suffix: str, settings: list[int]) -> bytes:
    if not is_picture(image):
        raise RecordingError(
            f"an image of shape {image.shape} and type {image.dtype} cannot be written; "
            f"allowed are uint8 of (height, width) or (height, width, 3)"
        )
    _, data = cv2.imencode(f".{suffix}", image, settings)
    return data.tobytes()


def _row(info: FrameInfo, image: str) -> list[str]:
    place = "" if info.place is None else str(info.place)
    return [_number(info.timestamp_s), image, *_pose(info.odometry), *_pose(info.reference), place]


def _pose(pose: Pose2D | None) -> list[str]:
    return ["", "", ""] if pose is None else [_number(pose.x_m), _number(pose.y_m), _number(pose.heading_rad)]


def _number(value: float | None) -> str:
    """The shortest text that reads back as the same float."""
    return "" if value is None else repr(float(value))
