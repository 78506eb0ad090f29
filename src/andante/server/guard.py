"""Keeps other pages, other machines and large requests away from a server that is meant for one person.

A page from elsewhere that a browser has open may send requests to any port of this machine. It cannot name this
server's address as its own, though: not in ``Host`` (DNS rebinding makes a name of its own point here, but the
browser still says that name), and not in ``Origin`` or ``Sec-Fetch-Site``.
"""

from __future__ import annotations

import ipaddress
from http import HTTPStatus
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from andante.server.messages import MAX_BODY_BYTES

_HEADERS = {
    # Only what this server sends itself; nothing inline, nothing from elsewhere, in nobody's frame.
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}
_READING = ("GET", "HEAD")
_LENGTH_DIGITS = 9


class Guard:
    """An ASGI application around another; ``host`` is the name or address that the server was told to listen on."""

    def __init__(self, app: ASGIApp, host: str) -> None:
        self._app = app
        self._names = {"localhost", host.lower()}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request, or refuse it."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        if scope["type"] != "http":
            return  # no web sockets here

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(_HEADERS)
            await send(message)

        refusal = self._refusal(scope["method"], Headers(scope=scope))
        if refusal is None:
            await self._app(scope, receive, send_with_headers)
        else:
            status, words = refusal
            await JSONResponse({"error": words}, status)(scope, receive, send_with_headers)

    def _refusal(self, method: str, headers: Headers) -> tuple[HTTPStatus, str] | None:
        """Status and reason where a request must not pass."""
        host = headers.get("host", "")
        if not self._is_own(host):
            return HTTPStatus.MISDIRECTED_REQUEST, f"this server is not {host[:60]!r}; open the address that it printed"
        site, origin = headers.get("sec-fetch-site", "none"), headers.get("origin")
        if site not in ("same-origin", "none") or (origin is not None and origin != f"http://{host}"):
            return HTTPStatus.FORBIDDEN, "another page asked for this; open the address that the server printed"
        return None if method in _READING else _body_refusal(headers)

    def _is_own(self, host: str) -> bool:
        """Addresses in digits are nobody's name, so no name server can make them point here."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in self._names:
            return True
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return True


def _body_refusal(headers: Headers) -> tuple[HTTPStatus, str] | None:
    """Status and reason where a body is not read; forms of other pages cannot send JSON without asking first."""
    if headers.get("content-type", "").split(";")[0].strip() != "application/json":
        return HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "a request needs a body of type application/json"
    length = headers.get("content-length", "")
    if not (length.isascii() and length.isdecimal()):
        return HTTPStatus.LENGTH_REQUIRED, "a request needs the length of its body"
    if len(length) > _LENGTH_DIGITS or int(length) > MAX_BODY_BYTES:
        return HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"a request has at most {MAX_BODY_BYTES} bytes"
    return None
