"""Where the anchor detector's weights come from: a file of the user's, or one download that is pinned and checked."""

from __future__ import annotations

import hashlib
import http.client
import os
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path

from andante.errors import InputError
from andante.landmarks.labels import read_file, write_file

URL = "https://github.com/Megvii-BaseDetection/YOLOX/releases/download/0.1.1rc0/yolox_nano.onnx"
SHA256 = "c789161ed43c8269fcd4e67c67eeeb4e80c622da2eb296a20bc6007bd18a0b7d"
"""Of the 3,659,407 bytes that were released (Apache-2.0)."""
MAX_BYTES = 2**25

_TIMEOUT_S = 60.0

Fetch = Callable[[str], bytes]


def default_weights() -> Path:
    """Where the download is kept: ``$XDG_CACHE_HOME/andante/weights/yolox_nano.onnx``."""
    given = os.environ.get("XDG_CACHE_HOME", "")
    # The specification says to ignore relative paths.
    root = Path(given) if Path(given).is_absolute() else Path.home() / ".cache"
    return root / "andante" / "weights" / "yolox_nano.onnx"


def fetched_weights(path: Path | None = None, fetch: Fetch | None = None) -> Path:
    """The released YOLOX-nano, from ``path`` (default ``default_weights``) where it is, else downloaded to there.

    Raises ``InputError`` where the download fails, and where its checksum is not that of the release: then nothing is
    written.
    """
    path = path or default_weights()
    if path.is_file() and _digest(read_file(path, MAX_BYTES)) == SHA256:
        return path
    data = (fetch or _downloaded)(URL)
    if (digest := _digest(data)) != SHA256:
        raise InputError(
            f"what {URL} gave has the SHA-256 {digest}, not {SHA256}; it was not kept: try again, or fetch the file "
            "yourself and give its path (--weights FILE)"
        )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path.parent} cannot be made: {error.strerror}; give a file with --weights FILE") from None
    write_file(path, data)
    return path


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _downloaded(url: str) -> bytes:
    try:
        with urllib.request.urlopen(url, timeout=_TIMEOUT_S) as answer:
            data: bytes = answer.read(MAX_BYTES + 1)
    except (urllib.error.URLError, http.client.HTTPException, OSError) as error:
        reason = getattr(error, "reason", error)
        raise InputError(
            f"the anchor detector cannot be downloaded from {url} ({reason}); connect to the internet once, or fetch "
            "the file elsewhere and give its path (--weights FILE)"
        ) from None
    return data
