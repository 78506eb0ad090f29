import re
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest

from andante.server.messages import MAX_BODY_BYTES

SHED = {"name": "shed", "right": 0.2, "up": 1.4, "width": 1.6, "height": 1.8}


@pytest.fixture
def drawing(client, searched):
    """A client whose bicycle is found."""
    searched(client.made.desk)
    return client


def picture(response):
    assert response.status_code == 200, response.text
    assert response.headers["content-type"] == "image/jpeg"
    return cv2.imdecode(np.frombuffer(response.content, np.uint8), cv2.IMREAD_COLOR)


def test_the_page_and_all_that_it_asks_for(client):
    page = client.get("/")
    assert page.headers["content-type"] == "text/html; charset=utf-8"
    wanted = set(re.findall(r'(?:href|src)="(/[^"]+)"', page.text))
    seen = set()
    while wanted - seen:
        path = min(wanted - seen)
        seen.add(path)
        answer = client.get(path)
        assert answer.status_code == 200, path
        wanted |= {f"/{name}" for name in re.findall(r'from "\./([^"]+)"', answer.text)}
    assert seen == {"/style.css", "/icon.svg", "/main.js", "/server.js", "/surface.js", "/tiles.js", "/geometry.js"}


def test_nothing_comes_from_elsewhere(client):
    for path in ("/", "/main.js", "/server.js", "/surface.js", "/tiles.js", "/geometry.js", "/style.css"):
        text = client.get(path).text
        assert "//" not in re.sub(r"^\s*//.*|[;{,] //.*", "", text, flags=re.M), path
        assert "style=" not in text, path
        assert " on" + "click=" not in text


def test_headers(client):
    for path in ("/", "/state", "/frames/0.jpg", "/nowhere"):
        headers = client.get(path).headers
        assert headers["content-security-policy"].startswith("default-src 'none'; script-src 'self'")
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["cache-control"] == "no-store"
        assert headers["cross-origin-resource-policy"] == "same-origin"


def test_a_whole_lesson(drawing):
    taught = drawing.post("/landmarks", json=SHED).json()["landmarks"]
    assert [one["name"] for one in taught] == ["shed"]
    assert not drawing.made.done
    answer = drawing.post("/save", json={"left_out": [{"landmark": "shed", "frames": [0, 7]}]})
    assert answer.json()["phase"] == "saved"
    assert answer.json()["saved"] == {
        "folder": "monday.landmarks", "files": ["shed.json"], "next": "andante map monday",
    }  # fmt: skip
    assert drawing.made.done == [True]
    assert len(drawing.made.saved[0][0].boxes) == 38


def test_search_and_remove(client):
    assert client.post("/search", json={"anchor": "bicycle"}).json()["kind"] == "bicycle"
    client.post("/search/stop", json={})
    for _ in range(1000):
        if client.get("/state").json()["phase"] == "draw":
            break
    client.post("/landmarks", json=SHED)
    assert client.post("/landmarks/remove", json={"name": "shed"}).json()["landmarks"] == []


def test_pictures(client, anchor_scene):
    whole = picture(client.get("/frames/3.jpg"))
    assert whole.shape == (160, 720, 3)
    np.testing.assert_allclose(whole, anchor_scene.picture(3), atol=90)
    box = anchor_scene.anchor(3)
    part = picture(client.get("/frames/3.jpg", params={"azimuth": box.azimuth_rad, "width": 1.5, "height_px": 80}))
    assert part.shape[0] == 80
    row = round(80 * (0.5 - box.elevation_rad / (2 * np.pi * 160 / 720)))
    assert part[row, part.shape[1] // 2, 2] > 150  # the red bicycle in the middle


@pytest.mark.parametrize(
    "path",
    [
        "/frames/..%2f..%2f..%2fetc%2fpasswd",
        "/frames/%2e%2e%2fframes.csv",
        "/frames/../../../etc/passwd",
        "/frames//etc/passwd.jpg",
        "/frames/..jpg",
        "/frames/etc.jpg",
        "/static/../app.py",
        "/app.py",
        "/..%5capp.py",
        "/openapi.json",
        "/docs",
    ],
)
def test_a_request_with_a_path_in_it(path, client):
    answer = client.get(path)
    assert answer.status_code in (404, 422)
    (message,) = answer.json().values()
    assert re.match("there is no such page; frames are asked for by number|a frame is asked for by its number", message)


@pytest.mark.parametrize(
    ("path", "status", "message"),
    [
        ("/frames/40.jpg", 400, "frame 40 does not exist; this recording has frames 0 to 39"),
        ("/frames/-1.jpg", 422, "a frame is asked for by its number, got '-1'"),
        ("/frames/" + "9" * 3000 + ".jpg", 422, f"a frame is asked for by its number, got '{'9' * 40}'"),
        ("/frames/1.jpg?width=9", 422, "width: .*, got '9'"),
        ("/frames/1.jpg?azimuth=nan", 422, "azimuth: .*, got 'nan'"),
        ("/frames/1.jpg?height_px=100000", 422, "height_px: .*, got '100000'"),
    ],
)
def test_frames_that_cannot_be(path, status, message, client):
    answer = client.get(path)
    assert answer.status_code == status
    assert re.fullmatch(message, answer.json()["error"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": "../../shed"}, "a landmark cannot be called '../../shed'"),
        ({"name": ""}, "a landmark cannot be called ''"),
        ({"width": 0}, "a landmark of 0 x 1.8 times the anchor's box cannot be"),
        ({"right": 1e9}, "a landmark 1e\\+09 to the right"),
        ({"up": 9}, "landmark 'shed' lies outside of the picture in 4[0-9] of 4|landmark 'shed' lies outside"),
        ({"up": "1"}, "up: input should be a valid number, got '1'"),
        ({"folder": "/etc"}, "folder: extra inputs are not permitted, got '/etc'"),
        ({"folder\n" + "x" * 99: 1}, r"'folder\\nx+: extra inputs are not permitted, got '1'$"),
        ({"name": 3}, "name: input should be a valid string, got '3'"),
    ],
)
def test_landmarks_that_cannot_be(change, message, drawing):
    answer = drawing.post("/landmarks", json={**SHED, **change})
    assert answer.status_code in (400, 422)
    assert re.match(message, answer.json()["error"])
    assert drawing.get("/state").json()["landmarks"] == []


def test_numbers_that_are_none(drawing):
    body = '{"name": "shed", "right": NaN, "up": 1, "width": 1, "height": 1}'
    answer = drawing.post("/landmarks", content=body, headers={"content-type": "application/json"})
    assert answer.status_code == 422
    assert "error" in answer.json()
    answer = drawing.post("/landmarks", content="{", headers={"content-type": "application/json"})
    assert answer.status_code == 422


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8123", "127.0.0.1.evil.example", "", "[::1", "a b"])
def test_another_name_for_this_machine_is_refused(host, client):
    answer = client.get("/state", headers={"host": host})
    assert answer.status_code == 421
    assert "open the address that it printed" in answer.json()["error"]


@pytest.mark.parametrize("host", ["localhost:8123", "127.0.0.1", "[::1]:8123", "192.168.1.7:80"])
def test_addresses_in_digits_are_served(host, client):
    assert client.get("/state", headers={"host": host}).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": "http://127.0.0.1:9999"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
    ],
)
def test_other_pages_are_refused(headers, client):
    for answer in (
        client.post("/search", json={"anchor": "bicycle"}, headers=headers),
        client.get("/", headers=headers),
    ):
        assert answer.status_code == 403
        assert "another page asked for this" in answer.json()["error"]
    assert client.made.finder.searched == []


def test_the_own_page_is_served(client):
    headers = {"origin": "http://127.0.0.1:8123", "sec-fetch-site": "same-origin"}
    assert client.post("/search", json={"anchor": "bicycle"}, headers=headers).status_code == 200


def test_bodies(client):
    form = client.post("/search", data={"anchor": "bicycle"})
    assert (form.status_code, form.json()["error"]) == (415, "a request needs a body of type application/json")
    large = client.post("/search", json={"anchor": "x" * MAX_BODY_BYTES})
    assert (large.status_code, large.json()["error"]) == (413, f"a request has at most {MAX_BODY_BYTES} bytes")
    chunked = client.post("/search", content=iter([b"{}"]), headers={"content-type": "application/json"})
    assert chunked.status_code == 411
    wrong = client.put("/search", json={})
    assert (wrong.status_code, wrong.json()["error"].split(",")[0]) == (405, "this address is asked in another way")


@pytest.mark.parametrize("body", ["{", "\xff", "[" * 50_000, '{"anchor": ' + "9" * 5000 + "}"])
def test_bodies_that_are_no_json(body, client):
    answer = client.post("/search", content=body.encode("latin1"), headers={"content-type": "application/json"})
    assert answer.status_code in (400, 422)
    assert answer.json()["error"] == "the body of this request is no JSON that can be read; reload the page"


@pytest.mark.parametrize(
    ("message", "error"),
    [
        ({"anchor": "bicycle", "frame": 3}, "one of several is told by a frame and an azimuth_deg, by both"),
        ({"anchor": "bicycle", "azimuth_deg": 3}, "one of several is told by a frame and an azimuth_deg, by both"),
        ({"anchor": "bicycle", "frame": 40, "azimuth_deg": 0}, "frame 40 does not exist, recording 'memory' has .* 39"),
        ({"anchor": "bicycle", "frame": 10**12, "azimuth_deg": 0}, "frame: input should be less than 1000000000"),
    ],
)
def test_choices_that_cannot_be(message, error, client):
    answer = client.post("/search", json=message)
    assert answer.status_code in (400, 422)
    assert re.match(error, answer.json()["error"]), answer.json()
    assert client.made.finder.searched == []


@pytest.mark.parametrize(
    ("left_out", "error"),
    [
        ([("shed", [1]), ("shed", [2])], "left_out names a landmark twice"),
        ([("shed", [1, 40])], "landmark 'shed' has no label in frame 40 that could be left out"),
        ([("tree", [1])], "there is no landmark 'tree'"),
    ],
)
def test_frames_that_cannot_be_left_out(left_out, error, drawing):
    drawing.post("/landmarks", json=SHED)
    body = {"left_out": [{"landmark": name, "frames": frames} for name, frames in left_out]}
    answer = drawing.post("/save", json=body)
    assert (answer.status_code in (400, 422), answer.json()) == (True, {"error": error})
    assert drawing.made.saved == []


def test_many_saves_at_once_save_once(drawing):
    drawing.post("/landmarks", json=SHED)
    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(lambda _: drawing.post("/save", json={}), range(8)))
    assert sorted(answer.status_code for answer in answers) == [200] + [400] * 7
    assert len(drawing.made.saved) == 1
    assert drawing.post("/landmarks/remove", json={"name": "shed"}).json()["error"].startswith("everything is saved")
    assert [one.name for one in drawing.made.desk.result[0]] == ["shed"]


def test_one_of_two_anchors(client):
    client.post("/search", json={"anchor": "bicycle", "frame": 12, "azimuth_deg": 350})
    for _ in range(1000):
        if client.get("/state").json()["phase"] == "draw":
            break
    (chosen,) = client.made.finder.searched
    assert chosen.frame == 12
    assert chosen.azimuth_rad == pytest.approx(-0.1745, abs=1e-3)
