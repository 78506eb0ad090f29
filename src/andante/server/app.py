"""The page's address book: which request does what at the desk."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from typing import Annotated, Any

from fastapi import BackgroundTasks, FastAPI, Path, Query, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, Response
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp

from andante.errors import AndanteError
from andante.landmarks.teaching import Relation
from andante.server.desk import Desk
from andante.server.guard import Guard
from andante.server.messages import MOST_FRAMES, Draw, Remove, Save, Search
from andante.server.pictures import Pictures

_FILES = {
    "index.html": "text/html; charset=utf-8",
    "style.css": "text/css; charset=utf-8",
    "main.js": "text/javascript; charset=utf-8",
    "server.js": "text/javascript; charset=utf-8",
    "geometry.js": "text/javascript; charset=utf-8",
    "surface.js": "text/javascript; charset=utf-8",
    "tiles.js": "text/javascript; charset=utf-8",
    "icon.svg": "image/svg+xml",
}
_FULL_CIRCLE_RAD = 6.2832
_NO_JSON = "the body of this request is no JSON that can be read; reload the page"
_REFUSALS = {
    400: _NO_JSON,  # numbers of thousands of digits, lists in lists in lists
    404: "there is no such page; frames are asked for by number, as /frames/0.jpg",
    405: "this address is asked in another way, its page with GET and its actions with POST; reload the page",
}


def teaching_app(desk: Desk, *, host: str, on_saved: Callable[[], None] = lambda: None) -> ASGIApp:
    """The application; ``on_saved`` is called when the answer that says so has been sent.

    The files of the page are read here, once, so that no request ever opens a file whose name it gives.
    """
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    _add_page(app)
    _add_pictures(app, Pictures(desk.surroundings, len(desk.recording.infos)))
    _add_actions(app, desk, on_saved)
    _add_faults(app)
    return Guard(app, host)


def _add_page(app: FastAPI) -> None:
    folder = files("andante.server").joinpath("static")
    for name, kind in _FILES.items():
        content = folder.joinpath(name).read_bytes()
        path = "/" if name == "index.html" else f"/{name}"
        app.add_api_route(path, _sender(content, kind), methods=["GET", "HEAD"])


def _sender(content: bytes, kind: str) -> Callable[[], Response]:
    def send() -> Response:
        return Response(content, media_type=kind)

    return send


def _add_pictures(app: FastAPI, pictures: Pictures) -> None:
    @app.get("/frames/{index}.jpg")
    def frame(
        index: Annotated[int, Path(ge=0, lt=MOST_FRAMES)],
        azimuth: Annotated[float, Query(ge=-_FULL_CIRCLE_RAD, le=_FULL_CIRCLE_RAD)] = 0.0,
        width: Annotated[float, Query(ge=0.05, le=_FULL_CIRCLE_RAD)] = _FULL_CIRCLE_RAD,
        height_px: Annotated[int | None, Query(ge=16, le=2048)] = None,
    ) -> Response:
        return Response(pictures.jpeg(index, azimuth, width, height_px), media_type="image/jpeg")


def _add_actions(app: FastAPI, desk: Desk, on_saved: Callable[[], None]) -> None:
    @app.get("/state")
    def state() -> dict[str, Any]:
        return desk.state()

    @app.post("/search")
    def search(message: Search) -> dict[str, Any]:
        desk.search(message.anchor, message.chosen())
        return desk.state()

    @app.post("/search/stop")
    def stop_search() -> dict[str, Any]:
        desk.stop_search()
        return desk.state()

    @app.post("/landmarks")
    def draw(message: Draw) -> dict[str, Any]:
        desk.draw(message.name, Relation(message.right, message.up, message.width, message.height))
        return desk.state()

    @app.post("/landmarks/remove")
    def remove(message: Remove) -> dict[str, Any]:
        desk.remove(message.name)
        return desk.state()

    @app.post("/save")
    def save(message: Save, after: BackgroundTasks) -> dict[str, Any]:
        desk.finish({one.landmark: one.frames for one in message.left_out})
        after.add_task(on_saved)
        return desk.state()


def _add_faults(app: FastAPI) -> None:
    @app.exception_handler(AndanteError)
    def expected(_: Request, error: AndanteError) -> JSONResponse:
        return JSONResponse({"error": str(error)}, 400)

    @app.exception_handler(RequestValidationError)
    def malformed(_: Request, error: RequestValidationError) -> JSONResponse:
        return JSONResponse({"error": _words(error)}, 422)

    @app.exception_handler(HTTPException)
    def unknown(_: Request, error: HTTPException) -> JSONResponse:
        return JSONResponse({"error": _REFUSALS.get(error.status_code, error.detail)}, error.status_code)

    @app.exception_handler(Exception)
    def bug(_: Request, __: Exception) -> JSONResponse:
        return JSONResponse({"error": "the server failed; the terminal in which it runs says why"}, 500)


def _words(error: RequestValidationError) -> str:
    """What is wrong with the first wrong value, without its content beyond 40 characters."""
    first = error.errors()[0]
    place = [str(part) for part in first["loc"]]
    if first["type"] == "json_invalid":
        return _NO_JSON
    if first["type"] == "value_error":
        return str(first["ctx"]["error"])
    if place[0] == "path":
        return f"a frame is asked for by its number, got {str(first['input'])[:40]!r}"
    # Keys are the sender's words too.
    where = " ".join(part if part.isidentifier() or part.isdecimal() else repr(part) for part in place[1:])[:60]
    return f"{where or 'the request'}: {str(first['msg']).lower()}, got {str(first.get('input'))[:40]!r}"
