"""COLMAP, imported only where it is used, and quiet."""

from __future__ import annotations

from types import ModuleType

from andante.errors import MissingExtraError

SEED = 0
"""Of all that COLMAP draws at random."""
_ONLY_FATAL = 3


def colmap() -> ModuleType:
    """The module ``pycolmap``; raises ``MissingExtraError`` where it is not installed."""
    try:
        import pycolmap
    except ImportError:
        raise MissingExtraError("pycolmap", "structure") from None
    # It reports every matched pair on stderr, and tells a pair without matches as an error.
    pycolmap.logging.minloglevel = _ONLY_FATAL
    return pycolmap
