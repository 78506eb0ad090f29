"""What a machine needs, one function a check."""

from __future__ import annotations

import os
import platform
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, distributions, version
from typing import Any

import cv2
import numpy as np
import scipy  # noqa: F401  loads the BLAS that is asked below
from threadpoolctl import threadpool_info  # type: ignore[import-untyped]

_PACKAGES = ("andante", "numpy", "scipy", "opencv-python-headless", "safetensors", "pydantic", "matplotlib")
_SLOW_DECODE_MS = 10.0
_LEAST_MEMORY_GB = 1.0


@dataclass(frozen=True)
class Check:
    """What was looked at, whether it will do, what was found, and what to do where it will not."""

    name: str
    ok: bool
    found: str
    advice: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)


def run_checks() -> list[Check]:
    """All checks, in about a tenth of a second."""
    checks: tuple[Callable[[], Check], ...] = (_python, _packages, _one_cv2, _processors, _decoding, _memory, _disk)
    return [check() for check in checks]


def _python() -> Check:
    found = f"{platform.python_version()} on {platform.system()} {platform.machine()}"
    return Check("python", sys.version_info >= (3, 11), found, "install Python 3.11 or newer")


def _packages() -> Check:
    versions = {name: _version(name) for name in _PACKAGES}
    missing = [name for name, found in versions.items() if found is None]
    found = ", ".join(f"{name} {number or 'missing'}" for name, number in versions.items())
    return Check("packages", not missing, found, f"run: pip install {' '.join(missing)}")


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _one_cv2() -> Check:
    """Two wheels with a cv2 overwrite each other's files, and pip does not notice."""
    names = {str(one.metadata["Name"]).lower().replace("_", "-") for one in distributions()}
    wheels = sorted(name for name in names if name.startswith("opencv-") and "python" in name)
    advice = f"run: pip uninstall -y {' '.join(wheels)} && pip install opencv-python-headless"
    return Check("one cv2 wheel", len(wheels) == 1, ", ".join(wheels) or "none", advice)


def _processors() -> Check:
    pools = [
        f"{pool['internal_api']} {pool['num_threads']}" for pool in threadpool_info() if pool["user_api"] == "blas"
    ]
    return Check("processors", True, f"{os.cpu_count() or 1}; BLAS threads: {', '.join(pools) or 'unknown'}")


def _decoding() -> Check:
    """The best of ten decodings of a 480 x 480 JPEG in grey."""
    rng = np.random.default_rng(0)
    picture = cv2.resize(rng.integers(0, 256, (120, 120, 3), dtype=np.uint8), (480, 480))
    _, jpeg = cv2.imencode(".jpg", picture)
    best = min(_milliseconds(lambda: cv2.imdecode(jpeg, cv2.IMREAD_GRAYSCALE)) for _ in range(10))
    advice = f"more than {_SLOW_DECODE_MS:g} ms: is the machine busy, or OpenCV built without libjpeg-turbo?"
    return Check("image decoding", best <= _SLOW_DECODE_MS, f"{best:.2f} ms for 480x480 px JPEG", advice)


def _milliseconds(action: Callable[[], object]) -> float:
    start = time.perf_counter()
    action()
    return 1e3 * (time.perf_counter() - start)


def _memory() -> Check:
    try:
        free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 1e9
    except (ValueError, OSError, AttributeError):  # not told on this system
        return Check("free memory", True, "unknown")
    advice = f"less than {_LEAST_MEMORY_GB:g} GB: close other programs"
    return Check("free memory", free >= _LEAST_MEMORY_GB, f"{free:.1f} GB", advice)


def _disk() -> Check:
    folder = tempfile.gettempdir()
    try:
        with tempfile.TemporaryFile() as file:
            file.write(b"andante")
    except OSError as error:
        return Check("temporary folder", False, f"{folder}: {error.strerror}", "point TMPDIR to a folder with space")
    return Check("temporary folder", True, f"{folder} can be written")
