"""Earlier versions of a map file: kept beside it, found again, put back byte by byte.

The versions of ``garden.andante`` lie in ``garden.andante.history/`` as ``0001-<hash>.andante``, oldest first, each the
very file that once was the map. A version is in there before its successor takes its place, and the map itself is only
ever replaced as a whole: whatever moment a process dies at, there is a complete map under its name. Two processes that
change one map take turns.
"""

from __future__ import annotations

import hashlib
import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from andante.errors import MapError
from andante.files import replace_file
from andante.mapping.slow_map import SlowMap

MAX_VERSIONS = 20
_NAME = re.compile(r"(\d{4,})-([0-9a-f]{16})\.andante")
_CHUNK = 2**20
_ABANDONED_S = 3600.0
"""Parts of files older than this belong to processes that were killed."""


@dataclass(frozen=True, slots=True)
class Version:
    """One version of a map: ``number`` counts from 1, ``modified_s`` is when its file was written (Unix time)."""

    number: int
    digest: str
    path: Path
    bytes: int
    modified_s: float


def digest_of(path: str | Path) -> str:
    """16 hex digits of the SHA-256 of a file; raises ``MapError`` where it cannot be read."""
    whole = hashlib.sha256()
    if Path(path).is_dir():
        raise MapError(f"{path} is a folder, not a map; where it is a recording, the map comes before it")
    try:
        with Path(path).open("rb") as file:
            while chunk := file.read(_CHUNK):
                whole.update(chunk)
    except OSError as error:
        raise MapError(f"map {path} cannot be read: {error.strerror}; make one with: andante map") from None
    return whole.hexdigest()[:16]


def versions_of(path: str | Path) -> list[Version]:
    """The versions kept of a map, oldest first; none where it was never changed."""
    folder = _folder(Path(path))
    found = []
    for entry in folder.iterdir() if folder.is_dir() else ():
        if match := _NAME.fullmatch(entry.name):
            status = entry.stat()
            found.append(Version(int(match[1]), match[2], entry, status.st_size, status.st_mtime))
    return sorted(found, key=lambda version: version.number)


def replace_map(slowmap: SlowMap, path: str | Path, *, expected: str | None = None) -> int:
    """Put a map in its place and keep what was there, if anything, as the newest version; gives its size in bytes.

    Raises ``MapError`` where the file is no longer the one with the digest ``expected``, as someone else changed it
    meanwhile, or where the place cannot be written. At most 20 versions are kept, the oldest go.
    """
    path = Path(path)
    if expected is None and not path.exists():
        return slowmap.save(path)
    with _alone(path):
        current = digest_of(path)
        if expected is not None and current != expected:
            raise MapError(
                f"map {path} was changed by someone else meanwhile; nothing was written, run the command again"
            )
        versions = versions_of(path)
        # What is replaced is the version before its successor, even where it came back by rolling back.
        if not versions or versions[-1].digest != current:
            _add_version(path, versions, current)
        size = slowmap.save(path)
        for version in versions_of(path)[:-MAX_VERSIONS]:
            version.path.unlink(missing_ok=True)
    return size


def roll_back(path: str | Path, number: int | None = None) -> Version:
    """Put a version back, byte by byte: number ``number``, or the one before the current one.

    The current map is kept as a version too, so that nothing is lost; rolling back again goes on to the version before.
    Raises ``MapError`` where there is no such version or the place cannot be written.
    """
    path = Path(path)
    with _alone(path):
        current, versions = digest_of(path), versions_of(path)
        version = _wanted(path, versions, current, number)
        if digest_of(version.path) != version.digest:
            raise MapError(f"version {version.number} of map {path} is damaged; choose another with --to")
        if all(one.digest != current for one in versions):
            _add_version(path, versions, current)
        _copy(version.path, path)
    return version


def _wanted(path: Path, versions: list[Version], current: str, number: int | None) -> Version:
    own = next((version.number for version in reversed(versions) if version.digest == current), None)
    earlier = [version for version in versions if own is None or version.number < own]
    wanted = earlier[-1:] if number is None else [version for version in versions if version.number == number]
    if not wanted:
        known = ", ".join(str(version.number) for version in versions) or "none"
        missing = "no earlier version" if number is None else f"no version {number}"
        raise MapError(f"map {path} has {missing}; versions kept: {known}; see: andante history {path}")
    return wanted[0]


def _folder(path: Path) -> Path:
    return path.with_name(f"{path.name}.history")


def _add_version(path: Path, versions: list[Version], digest: str) -> None:
    """Make the current file the newest version."""
    number = versions[-1].number + 1 if versions else 1
    folder = _folder(path)
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise MapError(f"the history of map {path} cannot be written: {error.strerror}; check {folder}") from None
    _copy(path, folder / f"{number:04d}-{digest}.andante")


@contextmanager
def _alone(path: Path) -> Iterator[None]:
    """Inside, no other process changes maps in this folder; parts that killed ones left behind are gone."""
    with _locked(path.parent):
        for part in (*path.parent.glob(f".{path.name}.*.part"), *_folder(path).glob(".*.part")):
            if time.time() - part.stat().st_mtime > _ABANDONED_S:
                part.unlink(missing_ok=True)
        yield


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    try:
        import fcntl
    except ImportError:  # not on Windows, where whoever comes second may have to run the command again
        yield
        return
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise MapError(f"folder {folder} cannot be opened: {error.strerror}; check the path") from None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _copy(source: Path, target: Path) -> None:
    """The bytes and times of a file under another name, all at once."""
    try:
        status = source.stat()
        replace_file(target, source.read_bytes())
        os.utime(target, ns=(status.st_atime_ns, status.st_mtime_ns))
    except OSError as error:
        raise MapError(f"{target} cannot be written: {error.strerror}; check space and permissions") from None
