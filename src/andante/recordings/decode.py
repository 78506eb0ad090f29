"""One image file to one array, safely."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.data import ImageArray
from andante.errors import ImageError
from andante.recordings.headers import read_header

IMAGE_SUFFIXES = (".jpg", ".jpeg", ".png", ".bmp", ".webp")
MAX_PIXELS = 64_000_000
_MAX_BYTES = 8 * MAX_PIXELS  # the largest honest file: 16 bits, four channels, not compressed


def is_picture(image: NDArray[Any]) -> bool:
    """Whether an array is what ``read_image`` gives: uint8 (height, width) or (height, width, 3), not empty."""
    return image.dtype == np.uint8 and image.ndim >= 2 and image.shape[2:] in ((), (3,)) and image.size > 0


def read_image(path: str | Path, *, colour: bool = False) -> ImageArray:
    """Read an image file as uint8: grey (height, width), or BGR (height, width, 3) where ``colour`` is true.

    JPEG, PNG, BMP and WebP of at most 64 megapixels; 16-bit images are reduced to their upper 8 bits and
    transparency is dropped. Pixels come as stored: an EXIF orientation is ignored, because a camera that
    looks straight up writes an arbitrary one. Raises ``ImageError``.
    """
    path = Path(path)
    try:
        if not path.exists():
            raise ImageError(f"image {path} does not exist; check the path")
        if not path.is_file():  # reading a pipe or a device might never end
            raise ImageError(f"image {path} is not a regular file; give the path of one image")
        if path.stat().st_size > _MAX_BYTES:
            raise ImageError(f"image {path}: {path.stat().st_size} bytes, at most {_MAX_BYTES} are read")
        data = path.read_bytes()
    except OSError as error:
        raise ImageError(f"image {path} cannot be read: {error.strerror}; check its permissions") from error
    return decode_image(data, colour=colour, name=f"image {path}")


def decode_image(data: bytes, *, colour: bool = False, name: str = "image") -> ImageArray:
    """Decode the bytes of an image file as ``read_image`` does; ``name`` begins the messages of errors."""
    if not data:
        raise ImageError(f"{name}: empty file; record or copy it again")
    try:
        header = read_header(data)
    except ImageError as error:
        raise ImageError(f"{name}: {error}") from None
    size = f"{header.width} x {header.height} pixels"
    if header.width * header.height > MAX_PIXELS:
        raise ImageError(f"{name}: declares {size}, at most {MAX_PIXELS / 1e6:g} megapixels are decoded; scale it down")
    if not header.complete:
        raise ImageError(f"{name}: truncated or damaged ({len(data)} bytes of {size}); record or copy it again")

    flags = (cv2.IMREAD_COLOR if colour else cv2.IMREAD_GRAYSCALE) | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    except cv2.error as error:
        raise ImageError(f"{name}: cannot be decoded ({error.err}); record or copy it again") from error
    if image is None:
        raise ImageError(f"{name}: cannot be decoded, its content is damaged; record or copy it again")
    return np.asarray(image, dtype=np.uint8)
