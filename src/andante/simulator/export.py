"""Renders sessions to disk in many processes: in order, resumable, whole sessions or nothing."""

from __future__ import annotations

import multiprocessing
from collections import deque
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import closing
from functools import lru_cache
from pathlib import Path
from typing import Self

import cv2

from andante.data import Frame, ImageArray
from andante.errors import ConfigError, RecordingError
from andante.recordings import FolderRecording, open_folder, write_recording
from andante.recordings.writer import ImageFormat
from andante.simulator.boxes import ObjectBox, boxes_csv, object_boxes
from andante.simulator.plan import Plan
from andante.simulator.recording import SimulatedRecording

Progress = Callable[[str, int, int], None]
"""Called with a session's name, its frames done and its frames in all."""

_LOOK_AHEAD = 4
_Picture = tuple[ImageArray, list[ObjectBox]]


def render_plan(
    plan: Plan,
    folder: str | Path,
    *,
    workers: int = 1,
    boxes: bool = False,
    image_format: ImageFormat = "jpg",
    progress: Progress | None = None,
) -> list[FolderRecording]:
    """Every session of a plan as the recording ``folder/NAME``; otherwise as ``render_sessions``."""
    folders = {session.name: Path(folder) / session.name for session in plan.sessions}
    return render_sessions(plan, folders, workers=workers, boxes=boxes, image_format=image_format, progress=progress)


def render_session(
    plan: Plan,
    session: str,
    folder: str | Path,
    *,
    workers: int = 1,
    boxes: bool = False,
    image_format: ImageFormat = "jpg",
    progress: Progress | None = None,
) -> FolderRecording:
    """One session of a plan as the recording ``folder``; otherwise as ``render_sessions``."""
    (recording,) = render_sessions(
        plan, {session: folder}, workers=workers, boxes=boxes, image_format=image_format, progress=progress
    )
    return recording


def render_sessions(
    plan: Plan,
    folders: Mapping[str, str | Path],
    *,
    workers: int = 1,
    boxes: bool = False,
    image_format: ImageFormat = "jpg",
    progress: Progress | None = None,
) -> list[FolderRecording]:
    """Sessions of a plan by name, each as a recording in a folder of its own, which appears when it is complete.

    Sessions that are there already are kept, so that a killed run goes on where it was. ``boxes`` writes a table of
    object boxes beside each, ``NAME.boxes.csv``. The bytes do not depend on ``workers``; more than one starts
    processes, so a script needs ``if __name__ == "__main__":``. Raises ``RecordingError`` where a folder holds
    something else, ``ConfigError`` for fewer than one worker, ``MissingExtraError`` without embreex.
    """
    with _Painters(workers) as painters:
        return [
            _rendered(
                SimulatedRecording(plan, name),
                Path(folder),
                painters,
                boxes=boxes,
                image_format=image_format,
                progress=progress,
            )
            for name, folder in folders.items()
        ]


def _rendered(
    recording: SimulatedRecording,
    folder: Path,
    painters: _Painters,
    *,
    boxes: bool,
    image_format: ImageFormat,
    progress: Progress | None,
) -> FolderRecording:
    table = folder.with_name(f"{folder.name}.boxes.csv")
    if folder.exists():
        if boxes and not table.exists():
            raise RecordingError(f"{folder} was rendered without boxes; remove it or choose another folder")
        return _kept(recording, folder, progress)
    try:
        return write_recording(
            folder,
            _frames(recording, painters, table if boxes else None, progress),
            name=recording.name,
            camera=recording.camera,
            conditions=recording.conditions,
            source="rendered",
            image_format=image_format,
        )
    except OSError:
        if not folder.exists():
            raise
        return _kept(recording, folder, progress)  # another process was faster


def _kept(recording: SimulatedRecording, folder: Path, progress: Progress | None) -> FolderRecording:
    """A finished session, if it is that of this plan."""
    finished = open_folder(folder)
    if finished.conditions.get("plan") != recording.conditions["plan"]:
        raise RecordingError(
            f"{folder} holds another recording, not session {recording.name!r} of this plan; "
            "remove it or choose another folder"
        )
    if progress is not None:
        progress(recording.name, len(recording.infos), len(recording.infos))
    return finished


def _frames(
    recording: SimulatedRecording, painters: _Painters, table: Path | None, progress: Progress | None
) -> Generator[Frame, None, None]:
    """All frames in order; the table of boxes is complete before the writer shows the folder."""
    rows: list[tuple[int, ObjectBox]] = []
    with closing(painters.pictures(recording, boxes=table is not None)) as pictures:
        for info, (image, found) in zip(recording.infos, pictures, strict=True):
            rows += [(info.index, box) for box in found]
            yield Frame(info, image)
            if progress is not None:
                progress(recording.name, info.index + 1, len(recording.infos))
    if table is not None:
        part = table.with_name(f".{table.name}.part")
        part.write_text(boxes_csv(rows), encoding="utf-8", newline="")
        part.replace(table)


class _Painters:
    """One process or many that render frames, for any number of sessions."""

    def __init__(self, workers: int) -> None:
        if workers < 1:
            raise ConfigError(f"workers = {workers} is not allowed; use 1 or more")
        self._workers = workers
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Self:
        if self._workers > 1:
            # Spawned, not forked: a fork would copy the threads of OpenCV and the BLAS half-way.
            self._pool = ProcessPoolExecutor(self._workers, multiprocessing.get_context("spawn"), _begin)
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)

    def pictures(self, recording: SimulatedRecording, *, boxes: bool) -> Generator[_Picture, None, None]:
        """All pictures in order; few are held at once."""
        if self._pool is None:
            yield from (_picture(recording, info.index, boxes) for info in recording.infos)
            return
        pending: deque[Future[_Picture]] = deque()
        for info in recording.infos:
            pending.append(self._pool.submit(_work, recording.plan, recording.name, info.index, boxes))
            if len(pending) >= _LOOK_AHEAD * self._workers:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()


def _begin() -> None:
    cv2.setNumThreads(1)


def _work(plan: Plan, session: str, index: int, boxes: bool) -> _Picture:
    return _picture(_own_recording(plan, session), index, boxes)


@lru_cache(maxsize=1)
def _own_recording(plan: Plan, session: str) -> SimulatedRecording:
    """A worker's scene: made at its first frame of a session, dropped at the first of the next."""
    return SimulatedRecording(plan, session)


def _picture(recording: SimulatedRecording, index: int, boxes: bool) -> _Picture:
    rendering = recording.rendering(index)
    if not boxes:
        return rendering.image, []
    names = recording.renderer.scene.names
    wraps = recording.plan.camera.model == "panorama"
    return rendering.image, object_boxes(rendering.object_id, names, wraps=wraps)
