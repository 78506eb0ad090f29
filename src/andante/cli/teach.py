"""``andante teach``: a recording and a person in, labels of landmarks out."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from andante.cli.options import AsJson
from andante.cli.output import examples, hint, print_facts, print_json, progress_bars
from andante.errors import InputError

if TYPE_CHECKING:
    from andante.landmarks.surroundings import Surroundings
    from andante.landmarks.teaching import AnchorFinder, Lesson, Relation
    from andante.landmarks.tracks import Chosen
    from andante.protocols import Recording
    from andante.server.desk import Saved

EPILOG = examples(
    "andante teach garden/monday",
    "andante teach garden/monday --anchor bicycle --offset 0,-1.2 --size 1.5,1.5 --name shed",
    "andante teach garden/monday --anchor bicycle --offset 0,-1.2 --size 1.5,1.5 --name shed "
    "--offset 2.5,-1 --size 1,3 --name birch --json",
)


_MOST_FRAMES = 10**9


def command(
    recording: Annotated[
        Path,
        typer.Argument(metavar="REC", show_default=False, help="A recording in which an anchor stands still."),
    ],
    *,
    anchor: Annotated[
        str | None, typer.Option(metavar="NAME", help="Kind of anchor, as bicycle. Default: chosen on the page.")
    ] = None,
    offset: Annotated[
        list[str] | None,
        typer.Option(
            metavar="RIGHT,DOWN",
            help="From the anchor's middle to the landmark's, in sizes of the anchor's box; above it is negative. "
            "Default: drawn on the page.",
        ),
    ] = None,
    size: Annotated[
        list[str] | None,
        typer.Option(metavar="WIDTH,HEIGHT", help="Of the landmark, in the same sizes. Default: drawn on the page."),
    ] = None,
    name: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="What the landmark is called; one --offset, --size and --name for each. Default: given on the page.",
        ),
    ] = None,
    which: Annotated[
        str | None,
        typer.Option(
            metavar="FRAME,DEGREES",
            help="Of two anchors of a kind the one nearest to this azimuth (left of the robot's forward is positive) "
            "in this frame. Default: there is only one.",
        ),
    ] = None,
    weights: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="YOLOX-nano as ONNX. Default: downloaded once, checked by its SHA-256."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder to write, a new one. Default: REC.landmarks.")
    ] = None,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Where the page is served. Default: 127.0.0.1, this machine only.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Of the page. Default: 0, any free one.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page. Default: it is.")] = True,
    as_json: AsJson = False,
) -> None:
    """Teach landmarks: show once where each lies beside a known object, on a local page or with options."""
    from andante.landmarks.lesson_files import check_new
    from andante.landmarks.lesson_folders import beside
    from andante.recordings import open_recording

    drawn = _drawn(name or [], offset or [], size or [])
    if anchor is None and (drawn or which is not None):
        raise typer.BadParameter("--offset and --which need --anchor: which kind?")
    room = _Classroom(recording, open_recording(recording), out or beside(recording), anchor, _chosen(which))
    check_new(room.folder)
    finder = anchor_finder(weights)
    if drawn:
        lessons, saved = _by_options(room, finder, drawn)
    else:
        lessons, saved = _on_page(room, finder, host=host, port=port, browser=browser)
    _tell(saved, lessons, as_json)


@dataclass(frozen=True)
class _Classroom:
    """What is taught in, where labels go, and which anchor was asked for."""

    path: Path
    recording: Recording
    folder: Path
    anchor: str | None
    chosen: Chosen | None

    @cached_property
    def surroundings(self) -> Surroundings:
        """The recording's panoramas."""
        from andante.landmarks.surroundings import Surroundings

        return Surroundings(self.recording)

    def save(self, lessons: Sequence[Lesson]) -> Saved:
        """Write the labels."""
        from andante.landmarks.lesson_files import write_lessons
        from andante.server.desk import Saved

        files = write_lessons(self.folder, self.recording, self.surroundings, lessons)
        return Saved(str(self.folder), tuple(file.name for file in files), next_command(self.path, self.folder))


def anchor_finder(weights: Path | None) -> AnchorFinder:
    """YOLOX-nano, from a file or a download whose checksum is known."""
    from andante.landmarks.search import AnchorSearch
    from andante.landmarks.weights import fetched_weights
    from andante.landmarks.yolox import AnchorDetector

    return AnchorSearch(AnchorDetector(weights or fetched_weights()))


def _drawn(names: Sequence[str], offsets: Sequence[str], sizes: Sequence[str]) -> list[tuple[str, Relation]]:
    """Landmarks from options; raises ``InputError`` unless each has all of them."""
    from andante.landmarks.labels import check_name
    from andante.landmarks.teaching import Relation

    if not len(names) == len(offsets) == len(sizes):
        raise InputError(
            f"each landmark needs one --name, one --offset and one --size; got {len(names)}, {len(offsets)} and "
            f"{len(sizes)} of them"
        )
    drawn = []
    for name, offset, size in zip(names, offsets, sizes, strict=True):
        check_name(name)
        (right, down), (width, height) = _pair(offset, "--offset"), _pair(size, "--size")
        drawn.append((name, Relation(right, -down, width, height)))
    doubles = [name for at, name in enumerate(names) if name.casefold() in [one.casefold() for one in names[:at]]]
    if doubles:
        raise InputError(f"--name {doubles[0]!r} is given twice; every landmark needs a name of its own")
    return drawn


def _pair(text: str, option: str) -> tuple[float, float]:
    try:
        first, second = (float(part) for part in text.split(","))
        if not (math.isfinite(first) and math.isfinite(second)):
            raise ValueError
    except ValueError:
        raise InputError(
            f"{option} {text!r:.40} is no pair of numbers: give two with a comma between them, as 1.5,-0.5"
        ) from None
    return first, second


def _by_options(
    room: _Classroom, finder: AnchorFinder, drawn: Sequence[tuple[str, Relation]]
) -> tuple[Sequence[Lesson], Saved]:
    """Without a page."""
    from andante.landmarks.teaching import find_track, teach

    kind, geometry = str(room.anchor), room.surroundings.geometry
    with progress_bars() as progress:
        track = find_track(
            finder, room.recording, kind, lambda done, total: progress(f"find {kind}", done, total), room.chosen
        )
    lessons = [teach(name, track, relation, geometry) for name, relation in drawn]
    return lessons, room.save(lessons)


def _on_page(
    room: _Classroom, finder: AnchorFinder, *, host: str, port: int, browser: bool
) -> tuple[Sequence[Lesson], Saved]:
    """With a person in front of a page."""
    import webbrowser

    from andante.server.teaching import serve_teaching

    def announce(url: str, local_only: bool) -> None:
        typer.echo(f"teach landmarks on {url} (Ctrl-C ends without saving)", err=True)
        if not local_only:
            hint(f"--host {host}: whoever reaches this machine can see the pictures and teach; else use 127.0.0.1")
        if browser:
            webbrowser.open(url)

    return serve_teaching(
        room.recording,
        room.surroundings,
        finder,
        room.save,
        announce=announce,
        anchor=room.anchor,
        chosen=room.chosen,
        host=host,
        port=port,
    )


def _chosen(which: str | None) -> Chosen | None:
    from andante.angles import wrapped
    from andante.landmarks.tracks import Chosen

    if which is None:
        return None
    frame, degrees = _pair(which, "--which")
    if not (0 <= frame < _MOST_FRAMES and frame == int(frame)):
        raise InputError(f"--which {which!r:.40}: a frame is a number from 0; give FRAME,DEGREES, as 12,-30")
    return Chosen(int(frame), wrapped(math.radians(degrees)))


def next_command(recording: Path, folder: Path) -> str:
    """What learns to find what was taught."""
    from andante.landmarks.lesson_folders import beside

    moved = [] if folder.resolve() == beside(recording) else ["--recordings", str(recording)]
    return shlex.join(["andante", "learn-landmarks", str(folder), *moved, "-o", f"{recording.resolve().name}.onnx"])


def _tell(saved: Saved, lessons: Sequence[Lesson], as_json: bool) -> None:
    landmarks: list[dict[str, Any]] = [
        {
            "name": one.name,
            "anchor": one.anchor,
            "labels": len(one.boxes),
            "offset": [one.relation.right, -one.relation.up],
            "size": [one.relation.width, one.relation.height],
        }
        for one in lessons
    ]
    if as_json:
        print_json({**saved.as_dict(), "landmarks": landmarks})
        return
    facts = {one["name"]: f"{one['labels']} labels, taught by the {one['anchor']}" for one in landmarks}
    print_facts(saved.folder, {**facts, "files": ", ".join(saved.files)})
    hint("look at the contact sheets (.png); a box that is wrong there is wrong in the labels")
    hint(f"next: {saved.next_command}")
