"""What can be told of a recording from its table and a few of its images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from andante.camera import MIN_CONFIDENCE, find_image_circle
from andante.data import CameraSpec, FrameInfo, ImageArray, PoseSource, Trajectory
from andante.errors import ImageError
from andante.protocols import Recording

_SAMPLE = 12
_DARK, _BRIGHT = 25.0, 235.0  # mean grey levels beyond which a picture shows little


def describe_recording(recording: Recording) -> dict[str, Any]:
    """Plain values; at most 12 images spread over the recording are decoded. Raises ``RecordingError``."""
    infos = recording.infos
    images, unreadable = _sample(recording)
    length_m, length_of = _length(infos)
    circle = _circle(recording.camera, images)
    brightness = _brightness(images)
    return {
        "kind": "recording",
        "name": recording.name,
        "frames": len(infos),
        "duration_s": infos[-1].timestamp_s - infos[0].timestamp_s,
        "length_m": length_m,
        "length_of": length_of,
        "poses": {
            "reference": sum(info.reference is not None for info in infos),
            "odometry": sum(info.odometry is not None for info in infos),
            "place": sum(info.place is not None for info in infos),
        },
        "conditions": dict(recording.conditions),
        "camera": asdict(recording.camera),
        "image_px": [images[0].shape[1], images[0].shape[0]] if images else None,
        "image_circle": circle,
        "brightness": brightness,
        "unreadable": unreadable,
        "hints": _hints(infos, circle, brightness, unreadable),
    }


def _sample(recording: Recording) -> tuple[list[ImageArray], list[str]]:
    """Images of one size, and what is wrong with the others."""
    infos = recording.infos
    images, unreadable = list[ImageArray](), list[str]()
    for index in np.unique(np.linspace(0, len(infos) - 1, min(_SAMPLE, len(infos))).astype(int)):
        try:
            image = recording.load(infos[index])
        except ImageError as error:
            unreadable.append(str(error))
            continue
        if images and image.shape != images[0].shape:
            unreadable.append(f"image {infos[index].image} has another size than the first")
        else:
            images.append(image)
    return images, unreadable


def _length(infos: Sequence[FrameInfo]) -> tuple[float | None, PoseSource | None]:
    """Metres driven, by reference poses where there are some, else by odometry."""
    sources: tuple[PoseSource, ...] = ("reference", "odometry")
    for source in sources:
        trajectory = Trajectory.of(infos, source)
        if trajectory.known.any():
            steps = np.diff(trajectory.xy_m[trajectory.known], axis=0)
            return float(np.linalg.norm(steps, axis=1).sum()), source
    return None, None


def _circle(camera: CameraSpec, images: list[ImageArray]) -> dict[str, Any] | None:
    if camera.model != "fisheye":
        return None
    if camera.centre_px is not None and camera.radius_px is not None:
        declared = {"centre_px": list(camera.centre_px), "radius_px": camera.radius_px}
        return {**declared, "confidence": None, "declared": True}
    if not images:
        return None
    found = find_image_circle(images)
    return {
        "centre_px": list(camera.centre_px or found.centre_px),
        "radius_px": camera.radius_px or found.radius_px,
        "confidence": found.confidence,
        "declared": False,
    }


def _brightness(images: list[ImageArray]) -> dict[str, float] | None:
    if not images:
        return None
    levels = [float(image.mean()) for image in images]
    return {"median": float(np.median(levels)), "darkest": min(levels), "brightest": max(levels)}


def _hints(
    infos: Sequence[FrameInfo],
    circle: dict[str, Any] | None,
    brightness: dict[str, float] | None,
    unreadable: list[str],
) -> list[str]:
    """What a user should know before mapping or evaluating."""
    hints = [f"of {min(_SAMPLE, len(infos))} images that were tried: {reason}" for reason in unreadable]
    if all(info.reference is None for info in infos):
        hints.append(
            "no reference poses (x_m, y_m): it cannot be evaluated against, and mapped only by other positions"
        )
    if circle is not None and not circle["declared"] and circle["confidence"] < MIN_CONFIDENCE:
        hints.append("no image circle was found: declare centre_px and radius_px in recording.toml")
    if brightness is not None and brightness["darkest"] < _DARK:
        hints.append(
            f"some images are dark (mean grey level {brightness['darkest']:.0f} of 255): night, or a covered lens?"
        )
    if brightness is not None and brightness["brightest"] > _BRIGHT:
        hints.append(
            f"some images are burnt out (mean grey level {brightness['brightest']:.0f} of 255): lower the exposure"
        )
    return hints
