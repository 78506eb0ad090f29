"""Serves the page on which a person teaches landmarks, until everything is saved."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event

from andante.errors import InputError, MissingExtraError
from andante.landmarks.surroundings import Surroundings
from andante.landmarks.teaching import AnchorFinder, Lesson
from andante.landmarks.tracks import Chosen
from andante.protocols import Recording
from andante.server.desk import Desk, Save, Saved

_PACKAGES = ("fastapi", "starlette", "uvicorn")


def serve_teaching(
    recording: Recording,
    surroundings: Surroundings,
    finder: AnchorFinder,
    save: Save,
    *,
    announce: Callable[[str, bool], None],
    anchor: str | None = None,
    chosen: Chosen | None = None,
    host: str = "127.0.0.1",
    port: int = 0,
) -> tuple[tuple[Lesson, ...], Saved]:
    """Wait for a person to teach; gives the landmarks, and what ``save`` gave of them.

    ``announce`` is told the address, and whether only this machine reaches it, once there is one. With ``anchor`` it
    is looked for at once, told from another one by ``chosen``. Raises ``InputError`` for an unknown anchor and an
    address that cannot be listened on, ``MissingExtraError`` without fastapi and uvicorn.
    """
    try:
        from andante.server.app import teaching_app
        from andante.server.running import listen, serve
    except ModuleNotFoundError as error:
        if error.name not in _PACKAGES:
            raise
        raise MissingExtraError(error.name, "landmarks") from None
    desk, done = Desk(recording, surroundings, finder, save), Event()
    address = listen(host, port)
    if anchor is not None:
        desk.search(anchor, chosen)
    serve(
        teaching_app(desk, host=host, on_saved=done.set),
        address,
        done,
        on_ready=lambda: announce(address.url, address.local_only),
    )
    if desk.result is None:
        raise InputError("the page was ended before anything was saved; start andante teach again")
    return desk.result
