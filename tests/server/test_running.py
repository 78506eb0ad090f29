import http.client
import socket
from threading import Event, Thread
from types import SimpleNamespace

import pytest

from andante.errors import InputError, MissingExtraError
from andante.landmarks.teaching import Relation
from andante.server.running import Address, listen
from andante.server.teaching import serve_teaching


def test_a_free_port_on_this_machine_only():
    address = listen("127.0.0.1", 0)
    try:
        port = address.listener.getsockname()[1]
        assert address.url == f"http://127.0.0.1:{port}/"
        assert address.local_only
    finally:
        address.listener.close()


def test_everywhere_is_told():
    address = listen("0.0.0.0", 0)
    try:
        assert address.url.startswith("http://localhost:")
        assert not address.local_only
    finally:
        address.listener.close()


def test_an_address_with_colons_has_brackets():
    listener = SimpleNamespace(getsockname=lambda: ("::1", 7, 0, 0))
    assert Address(listener, "::1").url == "http://[::1]:7/"


def test_a_port_that_is_taken():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=rf"--host 127.0.0.1 --port {port} cannot be listened on: .*another port"):
            listen("127.0.0.1", port)


def test_a_host_that_is_not_this_machine():
    with pytest.raises(InputError, match=r"--host 203.0.113.9 --port 0 cannot be listened on"):
        listen("203.0.113.9", 0)


def ask(url: str, method: str, path: str, body: str | None = None) -> int:
    """The status of one request."""
    connection = http.client.HTTPConnection(url.removeprefix("http://").rstrip("/"), timeout=20)
    try:
        connection.request(method, path, body, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        answer.read()
        return answer.status
    finally:
        connection.close()


def test_from_start_to_end_over_a_real_socket(make_desk):
    made, told, ready, ended = make_desk(), [], Event(), []

    def announce(url, local_only):
        told.extend([url, local_only])
        ready.set()

    def run():
        desk = made.desk
        ended.append(
            serve_teaching(
                desk.recording, desk.surroundings, made.finder, desk._save, announce=announce, anchor="bicycle"
            )
        )

    thread = Thread(target=run)
    thread.start()
    assert ready.wait(20)
    url, local_only = told
    assert local_only
    relation = '{"name": "shed", "right": 0.2, "up": 1.4, "width": 1.6, "height": 1.8}'
    while ask(url, "POST", "/landmarks", relation) != 200:
        pass  # until the bicycle is found
    assert ask(url, "GET", "/frames/3.jpg") == 200
    assert ask(url, "GET", "/frames/../../etc/passwd") in (404, 422)
    assert ask(url, "POST", "/save", "{}") == 200
    thread.join(20)
    ((lessons, saved),) = ended
    assert [one.relation for one in lessons] == [Relation(0.2, 1.4, 1.6, 1.8)]
    assert saved.folder == "monday.landmarks"
    with pytest.raises(OSError, match=r"refused|reset"):
        ask(url, "GET", "/state")


def test_without_the_extra(make_desk, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "uvicorn", None)
    monkeypatch.delitem(__import__("sys").modules, "andante.server.running")
    desk = make_desk().desk
    with pytest.raises(MissingExtraError, match=r"uvicorn is not installed; .*andante\[landmarks\]"):
        serve_teaching(desk.recording, desk.surroundings, desk._finder, desk._save, announce=lambda *_: None)
