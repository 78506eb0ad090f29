"""What was taught as files: labels and a contact sheet of every landmark, and all of them as COCO."""

from __future__ import annotations

import os
import shutil
import uuid
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2

from andante.camera import PanoramaGeometry
from andante.errors import InputError
from andante.landmarks.coco import export_coco
from andante.landmarks.contact_sheet import contact_sheet
from andante.landmarks.labels import Labels, write_file
from andante.landmarks.surroundings import Surroundings
from andante.landmarks.teaching import Lesson
from andante.protocols import Recording

_COCO_WIDTH_PX = 1024


def write_lessons(
    folder: Path, recording: Recording, surroundings: Surroundings, lessons: Sequence[Lesson]
) -> list[Path]:
    """Write ``NAME.json`` and ``NAME.png`` for every landmark and ``coco/`` to a new folder; gives what is in it.

    The folder appears only when it is complete. Raises ``InputError`` where it exists or cannot be written.
    """
    check_new(folder)
    part = folder.parent / f".{folder.name}.{uuid.uuid4().hex}.part"
    try:
        part.mkdir(parents=True)
        labels = [
            Labels(one.name, recording.name, one.boxes, content_hash=content, anchors=one.anchors)
            for content in [recording.content_hash()]
            for one in lessons
        ]
        for one, lesson in zip(labels, lessons, strict=True):
            one.save(part / f"{one.name}.json")
            sheet = contact_sheet(recording, surroundings, lesson)
            write_file(part / f"{one.name}.png", cv2.imencode(".png", sheet)[1].tobytes())
        export_coco(labels, recording, part / "coco", coco_geometry(surroundings.geometry))
        part.rename(folder)
    except OSError as error:
        raise InputError(f"{folder} cannot be written: {error.strerror}; choose another place with --out") from None
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return [folder / f"{one.name}.{kind}" for one in labels for kind in ("json", "png")] + [folder / "coco"]


def check_new(folder: Path) -> None:
    """Raise ``InputError`` where a new folder cannot be made: before the work that would be lost, not after it."""
    if os.path.lexists(folder):
        raise InputError(f"{folder} exists already; choose another folder with --out, or remove it first")
    place = next(parent for parent in folder.absolute().parents if os.path.lexists(parent))
    if not place.is_dir():
        raise InputError(f"{folder} cannot be made, {place} is no folder; choose another place with --out")
    if not os.access(place, os.W_OK | os.X_OK):
        raise InputError(f"{folder} cannot be made, {place} cannot be written to; choose another place with --out")


def coco_geometry(seen: PanoramaGeometry) -> PanoramaGeometry:
    """The panorama of exported pictures: the same elevations, 1024 px around at most."""
    width = min(seen.width_px, _COCO_WIDTH_PX)
    return replace(seen, width_px=width, height_px=max(1, round(width * seen.height_px / seen.width_px)))
