"""A socket on this machine, and a server on it until its work is done."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Callable
from dataclasses import dataclass
from threading import Event, Thread

import uvicorn
from starlette.types import ASGIApp

from andante.errors import InputError

_LET_ANSWERS_OUT_S = 3


@dataclass(frozen=True, slots=True)
class Address:
    """An open socket and how a browser on this machine reaches it."""

    listener: socket.socket
    host: str

    @property
    def url(self) -> str:
        """With the port that was free where 0 was asked for."""
        host = self.host if self.host not in ("0.0.0.0", "::") else "localhost"
        return f"http://{f'[{host}]' if ':' in host else host}:{self.listener.getsockname()[1]}/"

    @property
    def local_only(self) -> bool:
        """Whether no other machine can reach it."""
        return ipaddress.ip_address(self.listener.getsockname()[0]).is_loopback


def listen(host: str, port: int) -> Address:
    """Open a port, any free one for 0; raises ``InputError`` where that cannot be."""
    try:
        family, kind, protocol, _, place = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        listener = socket.socket(family, kind, protocol)
        try:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind(place)
            listener.listen()  # a browser that comes before the server runs only waits
        except BaseException:
            listener.close()
            raise
    except OSError as error:
        raise InputError(
            f"--host {host} --port {port} cannot be listened on: {error.strerror or error}; choose another port, or 0 "
            "for a free one, and an address of this machine"
        ) from None
    return Address(listener, host)


def serve(app: ASGIApp, address: Address, done: Event, *, on_ready: Callable[[], None] = lambda: None) -> None:
    """Answer requests until ``done`` is set or the person interrupts."""
    config = uvicorn.Config(
        app,
        lifespan="off",
        ws="none",
        log_level="warning",
        access_log=False,
        server_header=False,
        timeout_graceful_shutdown=_LET_ANSWERS_OUT_S,
    )
    server = uvicorn.Server(config)

    def end() -> None:
        done.wait()
        server.should_exit = True

    Thread(target=end, daemon=True).start()
    on_ready()
    server.run(sockets=[address.listener])
