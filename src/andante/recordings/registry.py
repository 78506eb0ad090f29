"""Formats of recordings by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from andante.errors import ConfigError
from andante.protocols import Recording
from andante.recordings.folder import open_folder
from andante.recordings.images import open_images

DEFAULT_FORMAT = "folder"

RecordingOpener = Callable[[Path], Recording]

_OPENERS: dict[str, RecordingOpener] = {"folder": open_folder, "images": open_images}


def register_format(name: str, opener: RecordingOpener) -> None:
    """Let ``open_recording(path, name)`` call ``opener``; raises ``ConfigError`` for a name that is taken."""
    if name in _OPENERS:
        raise ConfigError(f"format {name!r} is registered already; choose another name than {', '.join(_OPENERS)}")
    _OPENERS[name] = opener


def open_recording(path: str | Path, format: str | None = None) -> Recording:
    """Open a recording: ``recording.toml``, ``frames.csv`` and its images, or another registered format.

    ``format`` is "folder" (the default), "images" (a plain folder of images, see ``open_images``) or a name
    given to ``register_format``. Raises ``RecordingError`` for a recording that cannot be used, ``ConfigError``
    for an unknown format.
    """
    chosen = DEFAULT_FORMAT if format is None else format
    if chosen not in _OPENERS:
        raise ConfigError(f"format {chosen!r} of recordings is unknown; allowed are {', '.join(_OPENERS)}")
    return _OPENERS[chosen](Path(path))
