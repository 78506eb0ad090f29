"""What a recording holds, as one hash: for the provenance of a map, and against testing on training data."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

import numpy as np

from andante.data import FrameInfo, ImageArray

_FINGERPRINT_SIDE = 64


def hash_content(infos: Iterable[FrameInfo], pictures: Iterable[bytes | None]) -> str:
    """SHA-256 (hex) over the values of the table and the bytes of every picture, ``None`` where there is none.

    Names, of the recording and of its files, do not count: renamed or moved, the content is the same.
    """
    whole = hashlib.sha256()
    for info, picture in zip(infos, pictures, strict=True):
        values = (info.timestamp_s, info.odometry, info.reference, info.place)
        whole.update(repr(values).encode())
        whole.update(b"no picture" if picture is None else hashlib.sha256(picture).digest())
    return whole.hexdigest()


def picture_fingerprint(image: ImageArray) -> str:
    """16 hex digits for the pixels of a decoded picture, of which large ones are sampled on a grid.

    It follows a picture through a changed table, a cut recording or a lossless copy, where the hash of the whole
    recording does not. Two pictures that a camera took differ by their noise alone.
    """
    step = max(1, min(image.shape[:2]) // _FINGERPRINT_SIDE)
    pixels = np.ascontiguousarray(image[::step, ::step])
    return hashlib.blake2b(repr(image.shape).encode() + pixels.tobytes(), digest_size=8).hexdigest()
