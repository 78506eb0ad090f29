"""Labels as COCO JSON beside the panoramas that they belong to, and back.

Boxes are in pixels of the panorama: x from its left edge, y from its top. COCO knows no seam, so a box over the seam is
two annotations that share their ``seam_group``, first the one at the right edge of the picture, then the one at the
left; readers that do not know the key see two boxes of one category, which is what the picture shows. Parts beyond the
top or bottom row are cut off. An image lists the categories that are ``absent`` from it for certain; of the others
without an annotation nothing is known.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2

from andante.angles import wrapped
from andante.camera import PanoramaGeometry, Unwrapper, with_found_circle
from andante.errors import InputError
from andante.landmarks.boxes import Box
from andante.landmarks.labels import Labels, names_of, read_file, require_usable, write_file
from andante.protocols import Recording

ANNOTATIONS = "annotations.json"
MAX_BYTES = 2**28

_Pixels = tuple[float, float, float, float]  # x, y, width, height


def export_coco(labels: Sequence[Labels], recording: Recording, folder: str | Path, geometry: PanoramaGeometry) -> Path:
    """Write the panorama of every frame that is labelled and ``annotations.json`` into a new folder.

    ``labels`` are of landmarks in this one recording. Returns the path of the JSON. Raises ``InputError`` where they do
    not belong to it, ``ConfigError`` and ``RecordingError`` as unwrapping and reading do.
    """
    for one in labels:
        require_usable(one, recording, geometry.min_deg, geometry.max_deg)
    frames = sorted({frame for one in labels for frame in one.frames})
    folder = Path(folder)
    try:
        (folder / "images").mkdir(parents=True)
    except OSError as error:
        raise InputError(f"{folder / 'images'} cannot be made: {error.strerror}; choose another folder") from None
    unwrapper: Unwrapper | None = None
    for frame in recording.frames(frames, colour=True):
        if unwrapper is None:
            unwrapper = Unwrapper(with_found_circle(recording.camera, frame.image), frame.image.shape, geometry)
        name = image_name(frame.info.index)
        write_file(folder / name, cv2.imencode(".png", unwrapper(frame.image))[1].tobytes())
    path = folder / ANNOTATIONS
    write_file(path, json.dumps(to_coco(labels, geometry), indent=1).encode())
    return path


def image_name(frame: int) -> str:
    """Where the panorama of a frame lies."""
    return f"images/{frame:06d}.png"


def to_coco(labels: Sequence[Labels], geometry: PanoramaGeometry) -> dict[str, Any]:
    """Labels of one recording as a COCO dictionary: ``info``, ``images``, ``annotations``, ``categories``."""
    if not labels:
        raise InputError("there are no labels to export; teach a landmark first")
    if len(sources := {(one.recording, one.content_hash) for one in labels}) > 1:
        raise InputError(f"labels of {len(sources)} recordings cannot go into one COCO file; export each by itself")
    names = names_of(labels)
    if len(names) < len(labels):
        raise InputError("two sets of labels are of one landmark; join them first")
    images: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    for frame in sorted({frame for one in labels for frame in one.frames}):
        absent = [names.index(one.name) + 1 for one in labels if frame in one.absent]
        size = {"width": geometry.width_px, "height": geometry.height_px}
        images.append({"id": frame, "file_name": image_name(frame), **size, "absent": absent})
        for one in labels:
            if frame in one.boxes:
                annotations += _annotations(one.boxes[frame], frame, names.index(one.name) + 1, geometry)
    for number, annotation in enumerate(annotations, start=1):
        annotation["id"] = number
    return {
        "info": {
            "description": f"landmarks in recording {labels[0].recording}",
            "recording": labels[0].recording,
            "content_hash": labels[0].content_hash,
            "min_deg": geometry.min_deg,
            "max_deg": geometry.max_deg,
        },
        "images": images,
        "annotations": annotations,
        "categories": [{"id": i, "name": name, "supercategory": "landmark"} for i, name in enumerate(names, start=1)],
    }


def from_coco(values: Mapping[str, Any]) -> tuple[list[Labels], PanoramaGeometry]:
    """What ``to_coco`` was given, but for what lay beyond the picture; raises ``InputError`` for anything else."""
    try:
        return _from_coco(values)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InputError(
            f"this COCO file has no labels of landmarks as Andante exports them: {type(error).__name__} {error}"
        ) from None


def load_coco(path: str | Path) -> tuple[list[Labels], PanoramaGeometry]:
    """Read the JSON that ``export_coco`` wrote; raises ``InputError``."""
    try:
        values = json.loads(read_file(Path(path), MAX_BYTES))
    except ValueError as error:
        raise InputError(f"{path} is no JSON: {error}") from None
    return from_coco(values)


def box_pixels(box: Box, geometry: PanoramaGeometry) -> _Pixels:
    """(x, y, width, height) in pixels of the panorama, 0 <= x < its width; the box may reach over its edges."""
    per_rad = (
        geometry.width_px / (2.0 * math.pi),
        geometry.height_px / math.radians(geometry.max_deg - geometry.min_deg),
    )
    width, height = box.width_rad * per_rad[0], box.height_rad * per_rad[1]
    left = (math.pi - box.azimuth_rad - box.width_rad / 2.0) * per_rad[0]
    top = (math.radians(geometry.max_deg) - box.elevation_rad - box.height_rad / 2.0) * per_rad[1]
    left %= geometry.width_px
    return left if left < geometry.width_px else 0.0, top, width, height


def pixel_box(pixels: _Pixels, geometry: PanoramaGeometry) -> Box:
    """The inverse of ``box_pixels``."""
    x, y, width, height = pixels
    rad = 2.0 * math.pi / geometry.width_px, math.radians(geometry.max_deg - geometry.min_deg) / geometry.height_px
    azimuth = -wrapped((x + width / 2.0) * rad[0] - math.pi)  # (-pi, pi]
    return Box(azimuth, math.radians(geometry.max_deg) - (y + height / 2.0) * rad[1], width * rad[0], height * rad[1])


def _annotations(box: Box, frame: int, category: int, geometry: PanoramaGeometry) -> Iterator[dict[str, Any]]:
    """One annotation, or two for a box over the seam."""
    x, y, width, height = box_pixels(box, geometry)
    top, bottom = max(y, 0.0), min(y + height, float(geometry.height_px))
    beyond = x + width - geometry.width_px
    parts = [(x, width)] if beyond <= 0.0 else [(x, width - beyond), (0.0, beyond)]
    for left, extent in parts:
        yield {
            "image_id": frame,
            "category_id": category,
            "bbox": [left, top, extent, bottom - top],
            "area": extent * (bottom - top),
            "iscrowd": 0,
            "segmentation": [],
            **({"seam_group": f"{category}-{frame}"} if len(parts) > 1 else {}),
        }


def _from_coco(values: Mapping[str, Any]) -> tuple[list[Labels], PanoramaGeometry]:
    info, images = values["info"], values["images"]
    size = images[0]["width"], images[0]["height"]
    geometry = PanoramaGeometry(*size, info["min_deg"], info["max_deg"])
    names = {category["id"]: category["name"] for category in values["categories"]}
    parts: dict[tuple[int, int], list[list[float]]] = {}
    for annotation in values["annotations"]:
        parts.setdefault((annotation["category_id"], annotation["image_id"]), []).append(annotation["bbox"])
    boxes: dict[int, dict[int, Box]] = {category: {} for category in names}
    for (category, frame), found in parts.items():
        x, y, width, height = found[0]
        # The part that ends at the right edge begins the box; the other continues it.
        boxes[category][frame] = pixel_box((x, y, width + sum(part[2] for part in found[1:]), height), geometry)
    absent = {category: frozenset(image["id"] for image in images if category in image["absent"]) for category in names}
    source = info["recording"], info["content_hash"]
    return [
        Labels(name, source[0], boxes[category], absent[category], source[1]) for category, name in names.items()
    ], geometry
