"""``andante teach`` by options, with somebody who finds the anchor by heart; tests/server has the page itself."""

import json
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from andante.data import Frame
from andante.landmarks.labels import Labels
from andante.landmarks.teaching import AnchorTrack, Relation, teach
from andante.landmarks.tracks import Chosen
from andante.recordings import write_recording
from andante.server.desk import Saved

SHED = ("--anchor", "bicycle", "--offset", "0.2,-1.4", "--size", "1.6,1.8", "--name", "shed")


@pytest.fixture(scope="module")
def drive(anchor_scene, tmp_path_factory):
    """A recording on the disk."""
    recording = anchor_scene.recording()
    folder = tmp_path_factory.mktemp("garden") / "monday"
    frames = (Frame(frame.info, frame.image) for frame in recording.frames(colour=True))
    write_recording(folder, frames, name="monday", camera=recording.camera)
    return folder


@pytest.fixture
def finder(anchor_scene, monkeypatch):
    """What the command finds anchors with."""
    found = anchor_scene()
    monkeypatch.setattr("andante.cli.teach.anchor_finder", lambda weights: found)
    return found


def test_json(drive, finder, andante, anchor_scene, tmp_path):
    out = tmp_path / "labels"
    answer = andante("teach", drive, *SHED, "--out", out, "--json")
    assert answer.exit_code == 0, answer.stderr
    assert set(answer.json) == {"folder", "files", "next", "landmarks"}
    assert answer.json["folder"] == str(out)
    assert answer.json["files"] == ["shed.json", "shed.png", "coco"]
    (shed,) = answer.json["landmarks"]
    assert shed == {"name": "shed", "anchor": "bicycle", "labels": 40, "offset": [0.2, -1.4], "size": [1.6, 1.8]}
    assert answer.json["next"].startswith("andante learn-landmarks ")
    boxes = Labels.load(out / "shed.json").boxes
    assert all(boxes[index].iou(anchor_scene.shed(index)) > 0.99 for index in range(40))


def test_several_landmarks_beside_the_recording(drive, finder, andante):
    more = ("--offset", "-3,-1", "--size", "1,2.5", "--name", "old birch")
    answer = andante("teach", drive, *SHED, *more)
    assert answer.exit_code == 0, answer.stderr
    for words in ("shed", "old birch", "40 labels, taught by the bicycle"):
        assert words in answer.stdout
    assert "hint: next: andante learn-landmarks" in answer.stderr
    folder = drive.with_name("monday.landmarks")
    assert sorted(path.name for path in folder.iterdir()) == [
        "coco", "old birch.json", "old birch.png", "shed.json", "shed.png",
    ]  # fmt: skip
    assert finder.searched == [None]  # once for both
    again = andante("teach", drive, *SHED)
    assert again.exit_code == 1
    assert re.match(r"error: .*monday.landmarks exists already; choose another folder with --out", again.stderr)


def test_one_of_two_anchors(drive, finder, andante, tmp_path):
    answer = andante("teach", drive, *SHED, "--which", "12,-30", "--out", tmp_path / "x", "--json")
    assert answer.exit_code == 0, answer.stderr
    (chosen,) = finder.searched
    assert (chosen.frame, chosen.azimuth_rad) == (12, pytest.approx(-0.5236, abs=1e-3))
    assert isinstance(chosen, Chosen)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--anchor", "car", *SHED[2:]), "no car was found in any frame"),
        (("--anchor", "unicorn", *SHED[2:]), "no detector knows an anchor 'unicorn'; choose one of: bicycle, car, cow"),
        ((*SHED[:2], "--offset", "0,-12", *SHED[4:]), "landmark 'shed' lies outside of the picture in .* of 40 frames"),
        ((*SHED[:2], "--offset", "0;1", *SHED[4:]), "--offset '0;1' is no pair of numbers: give two with a comma"),
        ((*SHED[:2], "--offset", "nan,1", *SHED[4:]), "--offset 'nan,1' is no pair of numbers"),
        ((*SHED[:4], "--size", "0,1", *SHED[6:]), "a landmark of 0 x 1 times the anchor's box cannot be"),
        ((*SHED[:6], "--name", "../shed"), "a landmark cannot be called '../shed'"),
        (SHED[:6], "each landmark needs one --name, one --offset and one --size; got 0, 1 and 1"),
        ((*SHED, *SHED[2:6], "--name", "Shed"), "--name 'Shed' is given twice"),
        ((*SHED, "--which", "1.5,3"), "--which '1.5,3': a frame is a number from 0"),
    ],
)
def test_faults(options, message, drive, finder, andante, fails, tmp_path):
    fails(andante("teach", drive, *options, "--out", tmp_path / "x"), message)
    assert not (tmp_path / "x").exists()


def test_three_frames_only(drive, anchor_scene, monkeypatch, andante, fails, tmp_path):
    monkeypatch.setattr("andante.cli.teach.anchor_finder", lambda weights: anchor_scene(found=range(3)))
    answer = andante("teach", drive, *SHED, "--out", tmp_path / "x")
    fails(answer, "the bicycle was found in 3 frames only, at least 10 are needed; drive nearer")


def test_beside_what(drive, andante, tmp_path):
    answer = andante("teach", drive, *SHED[2:], "--out", tmp_path / "x")
    assert answer.exit_code == 2
    assert "--anchor" in answer.stderr


def test_a_detector_that_is_none(drive, andante, fails, tmp_path):
    weights = tmp_path / "weights.onnx"
    weights.write_bytes(b"no network")
    fails(andante("teach", drive, *SHED, "--out", tmp_path / "x", "--weights", weights), ".*weights.onnx")
    fails(andante("teach", drive, *SHED, "--out", tmp_path / "x", "--weights", tmp_path / "no"), ".*no")


def test_the_page(drive, finder, andante, tmp_path, monkeypatch):
    """What the command hands to the page, what it says and opens meanwhile, and what it tells in the end."""
    opened, given = [], SimpleNamespace()

    def serve(recording, surroundings, finder, save, *, announce, anchor, chosen, host, port):
        given.host, given.port, given.anchor, given.chosen = host, port, anchor, chosen
        announce("http://192.0.2.1:80/", host == "127.0.0.1")
        track = finder.find(recording, "bicycle", lambda done, total: None)
        lesson = teach("shed", AnchorTrack("bicycle", track), Relation(0, 1, 1, 1), surroundings.geometry)
        saved = save([lesson])
        assert isinstance(saved, Saved)
        return (lesson,), saved

    monkeypatch.setattr("andante.server.teaching.serve_teaching", serve)
    monkeypatch.setattr("webbrowser.open", opened.append)
    answer = andante("teach", drive, "--out", tmp_path / "x", "--host", "192.0.2.1", "--port", 80, "--json")
    assert answer.exit_code == 0, answer.stderr
    assert "teach landmarks on http://192.0.2.1:80/" in answer.stderr
    assert "hint: --host 192.0.2.1: whoever reaches this machine can see the pictures" in answer.stderr
    assert opened == ["http://192.0.2.1:80/"]
    assert json.loads(answer.stdout)["landmarks"][0]["name"] == "shed"
    assert vars(given) == {"host": "192.0.2.1", "port": 80, "anchor": None, "chosen": None}

    quiet = andante("teach", drive, "--out", tmp_path / "y", "--anchor", "bicycle", "--no-browser")
    assert quiet.exit_code == 0, quiet.stderr
    assert "hint: --host" not in quiet.stderr
    assert len(opened) == 1
    assert given.anchor == "bicycle"
    assert Path(tmp_path / "y" / "shed.png").exists()
