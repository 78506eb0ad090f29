"""What a person and a recording have worked out together so far; many requests ask it at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from threading import Event, Lock, Thread
from typing import Any

from andante.errors import AndanteError, InputError
from andante.landmarks.boxes import Box
from andante.landmarks.surroundings import Surroundings
from andante.landmarks.teaching import (
    SUGGESTED,
    AnchorFinder,
    AnchorTrack,
    Lesson,
    Relation,
    check_search,
    find_track,
    nearest,
    spread,
    teach,
)
from andante.landmarks.tracks import Chosen
from andante.landmarks.windows import elevations_rad
from andante.protocols import Recording

_PREVIEWS, _SHEET = 12, 24


class Phase(StrEnum):
    """What the page should show."""

    CHOOSE = "choose"
    SEARCH = "search"
    DRAW = "draw"
    SAVED = "saved"


@dataclass(frozen=True, slots=True)
class Saved:
    """Where the labels are, and the command that comes next."""

    folder: str
    files: tuple[str, ...]
    next_command: str

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {"folder": self.folder, "files": list(self.files), "next": self.next_command}


Save = Callable[[Sequence[Lesson]], Saved]


class _StoppedSearch(Exception):
    """The person does not want to wait any longer."""


@dataclass
class _Work:
    """All that changes, guarded by the desk's lock."""

    phase: Phase = Phase.CHOOSE
    problem: str | None = None
    done: int = 0
    total: int = 0
    kind: str | None = None
    track: AnchorTrack | None = None
    lessons: list[Lesson] = field(default_factory=list)
    saved: Saved | None = None
    stop: Event = field(default_factory=Event)


class Desk:
    """Searches for an anchor in the background, keeps what was taught, and writes it in the end through ``save``."""

    def __init__(self, recording: Recording, surroundings: Surroundings, finder: AnchorFinder, save: Save) -> None:
        self.recording, self.surroundings = recording, surroundings
        self._finder, self._save = finder, save
        self._work, self._lock = _Work(), Lock()

    @property
    def result(self) -> tuple[tuple[Lesson, ...], Saved] | None:
        """What was taught and where it was written, once it was."""
        saved = self._work.saved
        return None if saved is None else (tuple(self._work.lessons), saved)

    def search(self, kind: str, chosen: Chosen | None = None) -> None:
        """Begin to look for an anchor, which ``chosen`` tells from another one.

        Raises ``InputError`` for an unknown kind, for a frame that does not exist and while a search runs,
        ``LearningError`` for a recording that is too short.
        """
        check_search(self._finder, self.recording, kind, chosen)
        with self._lock:
            work = self._work
            if work.phase not in (Phase.CHOOSE, Phase.DRAW):
                raise InputError("a search is running, or everything is saved already; wait, or start anew")
            work.phase, work.kind, work.track, work.problem, work.stop = Phase.SEARCH, kind, None, None, Event()
            work.done, work.total = 0, len(self.recording.infos)
        Thread(target=self._find, args=(kind, chosen, work.stop), daemon=True).start()

    def stop_search(self) -> None:
        """Choose anew instead."""
        with self._lock:
            if self._work.phase is Phase.SEARCH:
                self._work.stop.set()

    def _find(self, kind: str, chosen: Chosen | None, stop: Event) -> None:
        def progress(done: int, total: int) -> None:
            if stop.is_set():
                raise _StoppedSearch
            self._work.done, self._work.total = done, total

        track, problem = None, None
        try:
            track = find_track(self._finder, self.recording, kind, progress, chosen)
        except _StoppedSearch:
            pass
        except AndanteError as error:
            problem = str(error)
        except Exception:
            problem = "the search failed; the terminal in which andante teach runs says why"
            raise
        finally:
            with self._lock:
                self._work.track, self._work.problem = track, problem
                self._work.phase = Phase.CHOOSE if track is None else Phase.DRAW

    def draw(self, name: str, relation: Relation) -> None:
        """Teach one landmark; raises ``InputError`` for a name that is taken and as ``teach`` does."""
        name = name.strip()
        with self._lock:
            if self._work.phase is not Phase.DRAW or self._work.track is None:
                raise InputError("there is no anchor to draw beside; choose one first")
            if any(one.name.casefold() == name.casefold() for one in self._work.lessons):
                raise InputError(f"there is a landmark {name[:40]!r} already; give another name or remove that one")
            self._work.lessons.append(teach(name, self._work.track, relation, self.surroundings.geometry))

    def remove(self, name: str) -> None:
        """Forget a landmark; raises ``InputError`` where there is none of this name, or all are saved already."""
        with self._lock:
            self._check_open()
            self._work.lessons.remove(self._lesson(name))

    def finish(self, left_out: Mapping[str, Sequence[int]]) -> None:
        """Write everything, without frames that the person left out; raises ``AndanteError``."""
        with self._lock:
            self._check_open()
            if not self._work.lessons:
                raise InputError("no landmark is drawn yet; draw one first")
            for name, frames in left_out.items():
                if unknown := set(frames) - self._lesson(name).boxes.keys():
                    raise InputError(
                        f"landmark {name[:40]!r} has no label in frame {min(unknown)} that could be left out"
                    )
            kept = [one.without(left_out.get(one.name, ())) for one in self._work.lessons]
            self._work.saved, self._work.lessons = self._save(kept), kept
            self._work.phase = Phase.SAVED

    def _check_open(self) -> None:
        if self._work.saved is not None:
            raise InputError("everything is saved already; start andante teach anew to change it")

    def _lesson(self, name: str) -> Lesson:
        for one in self._work.lessons:
            if one.name == name:
                return one
        raise InputError(f"there is no landmark {name[:40]!r}")

    def state(self) -> dict[str, Any]:
        """All that the page shows, as plain values: angles in radians, frames by index."""
        with self._lock:
            work = self._work
            return {
                "recording": {"name": self.recording.name, "frames": len(self.recording.infos)},
                "kinds": sorted(self._finder.names),
                "suggested": [kind for kind in SUGGESTED if kind in self._finder.names],
                "view": dict(zip(("min_rad", "max_rad"), elevations_rad(self.surroundings.geometry), strict=True)),
                "phase": str(work.phase),
                "problem": work.problem,
                "progress": {"done": work.done, "total": work.total},
                "kind": work.kind,
                "anchor": None if work.track is None else self._track(work.track),
                "landmarks": [self._taught(one) for one in work.lessons],
                "saved": None if work.saved is None else work.saved.as_dict(),
            }

    def _track(self, track: AnchorTrack) -> dict[str, Any]:
        frames = [
            {
                "index": index,
                "time_s": self.recording.infos[index].timestamp_s - self.recording.infos[0].timestamp_s,
                "followed": one.followed,
                "score": one.score if math.isfinite(one.score) else None,
                **_box(one.box),
            }
            for index, one in track.detections.items()
        ]
        previews = spread(list(track.detections), _PREVIEWS)
        return {"name": track.name, "best": track.best_frame(), "previews": previews, "frames": frames}

    def _taught(self, lesson: Lesson) -> dict[str, Any]:
        relation = lesson.relation
        frames = sorted(lesson.boxes)
        around = nearest(frames, spread(frames, _SHEET))
        sheet = [{"index": index, "around": near, **_box(lesson.boxes[index])} for index, near in around.items()]
        return {
            "name": lesson.name,
            "anchor": lesson.anchor,
            "frames": len(lesson.boxes),
            "right": relation.right,
            "up": relation.up,
            "width": relation.width,
            "height": relation.height,
            "sheet": sheet,
        }


def _box(box: Box) -> dict[str, float]:
    return {
        "azimuth": box.azimuth_rad,
        "elevation": box.elevation_rad,
        "width": box.width_rad,
        "height": box.height_rad,
    }
