"""Finds the image circle of a fisheye in its pictures, so that no calibration is needed.

Around the circle a picture is dark. Where rows and columns first leave the dark are candidates for the rim; dark
objects at the rim make some of them wrong, so a circle is drawn through random triples and the one that most
candidates support is kept. Then the brightness along the radius, at every degree, places the rim to a fraction of a
pixel. Parts of the circle that the picture cuts off have no rim and do not count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.data import CameraSpec, FloatArray, ImageArray
from andante.errors import ImageError

MIN_CONFIDENCE = 0.5
"""Below this, ``with_found_circle`` refuses a circle."""

_COARSE_PX = 256
_FINE_PX = 720
_DARK_MARGINS = (6.0, 12.0, 24.0)
_TRIPLES = 400
_DIRECTIONS = 360
_STEP_PX = 0.5
_VISIBLE_MARGIN_PX = 3.0
_FULL_COVERAGE = 0.35
_SURE = 0.9

_Float32Image = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class ImageCircle:
    """Centre (x, y) with pixel centres at whole numbers, radius in pixels, and confidence from 0 to 1.

    The confidence is the share of visible rim directions in which the picture turns dark on this very circle, less
    where they cover only a small arc.
    """

    centre_px: tuple[float, float]
    radius_px: float
    confidence: float


def find_image_circle(images: ImageArray | Sequence[ImageArray]) -> ImageCircle:
    """Find the image circle in one picture, or better in several from different places.

    Pictures are grey (h, w) or BGR (h, w, 3) uint8 of one size; their mean is used, in which passing dark objects
    and noise fade. Without a circle the confidence is near 0: callers decide. Deterministic.
    Raises ``ImageError`` for no pictures, mixed sizes or a wrong type.
    """
    full = _mean_grey([images] if isinstance(images, np.ndarray) else images)
    fine, fine_factor = _shrunk(full, _FINE_PX)
    coarse, coarse_factor = _shrunk(fine, _COARSE_PX)
    coarse = np.asarray(cv2.GaussianBlur(coarse, (0, 0), 1.0), np.float32)
    dark = float(np.percentile(coarse, 1.0))
    best = ImageCircle(((full.shape[1] - 1) / 2.0, (full.shape[0] - 1) / 2.0), min(full.shape) / 2.0, 0.0)
    for margin in _DARK_MARGINS:
        circle = _consensus_circle(_rim_candidates(coarse > dark + margin), min(coarse.shape))
        if circle is None:
            continue
        found = _refined(fine, _enlarged(circle, coarse_factor))
        if found.confidence > best.confidence:
            best = _enlarged(found, fine_factor)
        if best.confidence > _SURE:
            break
    return best


def with_found_circle(spec: CameraSpec, images: ImageArray | Sequence[ImageArray]) -> CameraSpec:
    """The camera with ``centre_px`` and ``radius_px``, found in the images where not declared.

    Raises ``ImageError`` where no circle is found with a confidence of at least ``MIN_CONFIDENCE``.
    """
    if spec.model != "fisheye" or (spec.centre_px is not None and spec.radius_px is not None):
        return spec
    circle = find_image_circle(images)
    if circle.confidence < MIN_CONFIDENCE:
        raise ImageError(
            f"found no image circle: confidence {circle.confidence:.2f}, at least {MIN_CONFIDENCE} is needed; "
            "give images from several places in daylight, or declare centre_px and radius_px"
        )
    return replace(
        spec,
        centre_px=circle.centre_px if spec.centre_px is None else spec.centre_px,
        radius_px=circle.radius_px if spec.radius_px is None else spec.radius_px,
    )


def _mean_grey(images: Sequence[ImageArray]) -> _Float32Image:
    """Mean of the pictures in grey."""
    if not images:
        raise ImageError("finding the image circle needs at least one image, got none")
    shape = images[0].shape[:2]
    total = np.zeros(shape, np.float32)
    for image in images:
        if image.dtype != np.uint8 or image.shape[:2] != shape or image.shape[2:] not in ((), (3,)):
            raise ImageError(
                f"finding the image circle needs grey or BGR uint8 images of one size {shape}, "
                f"got shape {image.shape} and type {image.dtype}"
            )
        total += image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    return total / np.float32(len(images))


def _shrunk(image: _Float32Image, longest_px: int) -> tuple[_Float32Image, int]:
    """The picture shrunk by a whole factor until it is no longer than asked, and the factor."""
    factor = int(np.ceil(max(image.shape) / longest_px))
    height, width = image.shape[0] // factor, image.shape[1] // factor
    if factor == 1 or min(height, width) == 0:
        return image, 1
    part = image[: height * factor, : width * factor]
    return np.asarray(cv2.resize(part, (width, height), interpolation=cv2.INTER_AREA), np.float32), factor


def _enlarged(circle: ImageCircle, factor: int) -> ImageCircle:
    """The circle in the picture before it was shrunk."""
    x, y = ((position + 0.5) * factor - 0.5 for position in circle.centre_px)
    return ImageCircle((x, y), circle.radius_px * factor, circle.confidence)


def _rim_candidates(bright: NDArray[np.bool_]) -> FloatArray:
    """(n, 2) first and last bright pixel (x, y) of every row and column, without those on the picture's border."""
    points = []
    for transposed, mask in ((False, bright), (True, bright.T)):
        lines = np.flatnonzero(mask.any(axis=1))
        first = mask[lines].argmax(axis=1)
        last = mask.shape[1] - 1 - mask[lines, ::-1].argmax(axis=1)
        for position in (first - 0.5, last + 0.5):
            inside = (position > 1.0) & (position < mask.shape[1] - 2.0)
            pair = np.column_stack([position, lines])[inside]
            points.append(pair[:, ::-1] if transposed else pair)
    return np.concatenate(points)


def _consensus_circle(points: FloatArray, size: int) -> ImageCircle | None:
    """The circle with most candidates within a pixel and a half, through triples of them."""
    if len(points) < 16:
        return None
    # A fixed seed: the same pictures give the same circle.
    triples = points[np.random.default_rng(0).integers(len(points), size=(_TRIPLES, 3))]
    origin, b, c = triples[:, 0], triples[:, 1] - triples[:, 0], triples[:, 2] - triples[:, 0]
    cross = 2.0 * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    usable = np.abs(cross) > size  # nearly straight triples make wild circles
    origin, b, c, cross = origin[usable], b[usable], c[usable], cross[usable]
    bb, cc = (b**2).sum(axis=1), (c**2).sum(axis=1)
    offset = np.column_stack([c[:, 1] * bb - b[:, 1] * cc, b[:, 0] * cc - c[:, 0] * bb]) / cross[:, None]
    radius = np.hypot(*offset.T)
    sane = (radius > 0.2 * size) & (radius < 1.5 * size)
    if not sane.any():
        return None
    centre, radius = (origin + offset)[sane], radius[sane]
    distance = np.hypot(points[None, :, 0] - centre[:, :1], points[None, :, 1] - centre[:, 1:])
    support = (np.abs(distance - radius[:, None]) < 1.5).sum(axis=1)
    best = int(support.argmax())
    return ImageCircle((float(centre[best, 0]), float(centre[best, 1])), float(radius[best]), 0.0)


def _refined(image: _Float32Image, circle: ImageCircle) -> ImageCircle:
    """The circle fitted to the rim found along each direction, with its confidence."""
    for _ in range(3):
        edges, visible = _rim_edges(image, circle)
        known = np.flatnonzero(np.isfinite(edges))
        if len(known) < 16:
            return replace(circle, confidence=0.0)
        fitted = _fitted(edges[known], _directions()[known], circle)
        moved = np.hypot(*np.subtract(fitted.centre_px, circle.centre_px)) + abs(fitted.radius_px - circle.radius_px)
        if not moved < 0.2 * circle.radius_px:  # the points are no circle
            return replace(circle, confidence=0.0)
        circle = fitted
    edges, visible = _rim_edges(image, circle)
    agreeing = int((np.abs(edges - circle.radius_px) < max(1.5, 0.01 * circle.radius_px)).sum())
    coverage = min(1.0, agreeing / (_FULL_COVERAGE * _DIRECTIONS))
    return replace(circle, confidence=coverage * agreeing / max(1, int(visible.sum())))


def _directions() -> FloatArray:
    return np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False)


def _rim_edges(image: _Float32Image, circle: ImageCircle) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Radius at which the picture turns dark for good, NaN where it does not; and which directions are visible.

    Both (directions,). A direction is visible where the picture goes on a little beyond the circle.
    """
    reach = max(8.0, 0.05 * circle.radius_px)
    radii = circle.radius_px + np.arange(-reach, reach, _STEP_PX)
    cos, sin = np.cos(_directions())[:, None], np.sin(_directions())[:, None]
    x = (circle.centre_px[0] + radii * cos).astype(np.float32)
    y = (circle.centre_px[1] + radii * sin).astype(np.float32)
    profile = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    # Along the rim neighbours look alike, so averaging there removes noise without moving the edge.
    profile = np.asarray(cv2.blur(profile, (3, 5)), np.float64)
    height, width = image.shape
    inside = (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)
    margin = int(_VISIBLE_MARGIN_PX / _STEP_PX)
    rim = int(np.searchsorted(radii, circle.radius_px))
    visible = inside[:, rim + margin]
    surround = profile[:, rim + margin :][inside[:, rim + margin :]]
    if surround.size == 0:
        return np.full(_DIRECTIONS, np.nan), visible
    dark = np.median(surround)
    noise = 1.4826 * np.median(np.abs(surround - dark))
    content = inside & (profile > dark + max(6.0, 4.0 * noise))
    last = _last_true(content)
    rows = np.arange(_DIRECTIONS)
    level = profile[rows[:, None], np.clip(last[:, None] - np.arange(3, 8), 0, None)].mean(axis=1)
    half = (dark + level) / 2.0
    crossing = np.minimum(_last_true(inside & (profile > half[:, None])), len(radii) - 2)
    before, after = profile[rows, crossing], profile[rows, crossing + 1]
    edges = radii[crossing] + _STEP_PX * (before - half) / np.where(before > after, before - after, np.inf)
    # The dark has to go on for a while, or it was only the end of the picture or of the window.
    ends = np.minimum(last + margin, len(radii) - 1)
    sure = visible & content.any(axis=1) & (last + margin < len(radii)) & inside[rows, ends]
    return np.where(sure, edges, np.nan), visible


def _last_true(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """(rows,) index of the last true column; the last column where there is none."""
    return np.asarray(mask.shape[1] - 1 - mask[:, ::-1].argmax(axis=1))


def _fitted(radii: FloatArray, directions: FloatArray, circle: ImageCircle) -> ImageCircle:
    """Robust least squares (Gauss-Newton, Cauchy weights) through points given as polar coordinates."""
    x = circle.centre_px[0] + radii * np.cos(directions)
    y = circle.centre_px[1] + radii * np.sin(directions)
    unknowns = np.array([*circle.centre_px, circle.radius_px])
    for _ in range(10):
        right, down = x - unknowns[0], y - unknowns[1]
        distance = np.hypot(right, down)
        residual = distance - unknowns[2]
        scale = max(0.3, 1.4826 * float(np.median(np.abs(residual))))
        weight = 1.0 / (1.0 + (residual / scale) ** 2)
        slopes = np.column_stack([right / distance, down / distance, np.ones_like(distance)])
        weighted = slopes * weight[:, None]
        # The ridge keeps the step finite where the points cover a short arc.
        unknowns += np.linalg.solve(weighted.T @ slopes + 1e-6 * np.eye(3), weighted.T @ residual)
    return ImageCircle((float(unknowns[0]), float(unknowns[1])), float(unknowns[2]), circle.confidence)
