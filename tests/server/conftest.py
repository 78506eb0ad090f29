"""A desk with a recording on it, and somebody who saves nothing."""

import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from fastapi.testclient import TestClient

from andante.landmarks.surroundings import Surroundings
from andante.server.app import teaching_app
from andante.server.desk import Desk, Saved

HOME = "http://127.0.0.1:8123"


@pytest.fixture
def make_desk(anchor_scene) -> Callable[..., Any]:
    """``make_desk(found=...)`` -> desk, what was given to save, and how often the application said that it is done."""

    def make(**options: Any) -> SimpleNamespace:
        finder, saved, done = anchor_scene(**options), [], []
        recording = finder.recording()

        def save(lessons):
            saved.append(list(lessons))
            return Saved("monday.landmarks", tuple(f"{one.name}.json" for one in lessons), "andante map monday")

        desk = Desk(recording, Surroundings(recording), finder, save)
        app = teaching_app(desk, host="127.0.0.1", on_saved=lambda: done.append(True))
        return SimpleNamespace(desk=desk, finder=finder, saved=saved, done=done, app=app)

    return make


def searched(desk: Desk, kind: str = "bicycle") -> dict[str, Any]:
    """The state after a search."""
    desk.search(kind)
    for _ in range(500):
        state = desk.state()
        if state["phase"] != "search":
            return state
        time.sleep(0.01)
    raise AssertionError("the search does not end")


@pytest.fixture(name="searched")
def searched_fixture() -> Callable[..., dict[str, Any]]:
    return searched


@pytest.fixture
def client(make_desk):
    """A page's view of a fresh desk."""
    made = make_desk()
    with TestClient(made.app, base_url=HOME) as opened:
        opened.made = made
        yield opened
