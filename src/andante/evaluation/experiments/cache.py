"""What was rendered or computed once is not done again: everything lies under a name that its content decides."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import andante
from andante.errors import InputError
from andante.evaluation.files import write_text
from andante.recordings import FolderRecording
from andante.simulator import Plan, Progress, render_sessions

_RESULTS = "results"
# What decides a result, besides the pictures, whose fingerprints have a recipe number of their own.
_DECISIVE = (
    "angles.py",
    "data.py",
    "sfa",
    "camera",
    "recordings",
    "sequences",
    "features",
    "landmarks",
    "mapping",
    "baselines",
    "evaluation/alignment.py",
)
_DECISIVE_HERE = ("contenders.py", "drives.py", "trials.py")
_DECISIVE_OF_TRACKS = (
    *("localization", "evaluation/figures.py", "evaluation/recovery.py"),
    *(
        f"evaluation/experiments/{name}.py"
        for name in (
            *("followers", "gaze", "gaze_following", "gaze_rivals", "landmark_trials", "landmark_world", "occlusion"),
            *("rides", "scenarios", "stress", "told"),
        )
    ),
)
_DECISIVE_OF_COMPARISONS = tuple(
    f"evaluation/{name}.py" for name in ("answers", "compare", "frame_fit", "running", "staged", "tracking")
)


def default_cache() -> Path:
    """The user's folder for rendered sessions and results: ``$XDG_CACHE_HOME/andante/simulated``."""
    given = os.environ.get("XDG_CACHE_HOME", "")
    # The specification says to ignore relative paths.
    root = Path(given) if Path(given).is_absolute() else Path.home() / ".cache"
    return root / "andante" / "simulated"


def rendered(
    plan: Plan, cache: Path, *, workers: int = 1, progress: Progress | None = None
) -> dict[str, FolderRecording]:
    """Every session of a plan as ``cache/FINGERPRINT/NAME``, rendered only where it is not there.

    Another plan renders what it changes and leaves the rest. Raises as ``render_sessions`` does.
    """
    folders = {session.name: cache / plan.fingerprint(session.name) / session.name for session in plan.sessions}
    found = render_sessions(plan, folders, workers=workers, progress=progress)
    return dict(zip(folders, found, strict=True))


class ResultStore:
    """Finished parts of experiments, one JSON file each; the key says all that a part depends on."""

    def __init__(self, cache: Path) -> None:
        self._folder = cache / _RESULTS

    def load(self, key: Mapping[str, Any]) -> dict[str, Any] | None:
        """What was saved under a key; ``None`` where there is nothing, or nothing that can be read."""
        try:
            stored = json.loads(self._path(key).read_text(encoding="utf-8"))
        except (FileNotFoundError, ValueError):  # damaged: as good as missing, since it can be made again
            return None
        except OSError as error:
            raise InputError(f"result {error.filename} cannot be read: {error.strerror}; remove it") from None
        if not isinstance(stored, dict) or stored.get("key") != json.loads(json.dumps(key)):
            return None
        result = stored.get("result")
        return result if isinstance(result, dict) and result else None

    def save(self, key: Mapping[str, Any], result: Mapping[str, Any]) -> None:
        """Write whole or not at all; raises ``InputError`` where that fails."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"cache folder {self._folder} cannot be made: {error.strerror}; choose another place"
            ) from None
        write_text(self._path(key), json.dumps({"key": key, "result": result}, allow_nan=False))

    def _path(self, key: Mapping[str, Any]) -> Path:
        digest = hashlib.sha256(json.dumps(key, sort_keys=True, allow_nan=False).encode()).hexdigest()
        return self._folder / f"{digest[:32]}.json"


@lru_cache(maxsize=4)
def code_hash(*, tracking: bool = False, comparing: bool = False) -> str:
    """16 hex digits that change with the part of the package's source that decides a result.

    That of a track depends on more than that of single images, and that of a comparison on more again.
    """
    package, here = Path(andante.__file__).parent, Path(__file__).parent
    roots = [*(package / name for name in _DECISIVE), *(here / name for name in _DECISIVE_HERE)]
    if tracking:
        roots += [package / name for name in _DECISIVE_OF_TRACKS]
    if comparing:
        roots += [package / name for name in ("localization", "evaluation/figures.py", *_DECISIVE_OF_COMPARISONS)]
    return source_hash(*roots)


def source_hash(*roots: Path) -> str:
    """16 hex digits that change with the source files of the package at or below these places."""
    package = Path(andante.__file__).parent
    sources = sorted(path for root in roots for path in ([root] if root.is_file() else root.rglob("*.py")))
    digest = hashlib.sha256()
    for path in sources:
        digest.update(path.relative_to(package).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]
