"""What a recording holds, as one hash: for the provenance of a map, and against testing on training data."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

from andante.data import FrameInfo


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
