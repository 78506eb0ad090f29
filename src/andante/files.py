"""Writes files whole or not at all."""

from __future__ import annotations

import os
import uuid
from pathlib import Path


def replace_file(path: Path, data: bytes) -> None:
    """Write a file beside its place and put it there, so that a reader sees the old one or the new one.

    Raises ``OSError`` as writing does.
    """
    part = path.parent / f".{path.name}.{uuid.uuid4().hex}.part"
    try:
        with part.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except BaseException:  # an interrupt too must leave nothing behind
        part.unlink(missing_ok=True)
        raise
