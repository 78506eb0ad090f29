"""``andante teach`` by options, with somebody who finds the anchor by heart; tests/server has the page itself."""

import importlib.util
import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from andante.data import Frame
from andante.landmarks.labels import Labels
from andante.landmarks.search import AnchorSearch
from andante.landmarks.teaching import AnchorTrack, Relation, teach
from andante.landmarks.tracks import Chosen
from andante.landmarks.yolox import Found
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
        ((*SHED[:4], "--size", "18,1", *SHED[6:]), "'shed' would be more than 180 degrees wide in 40 of 40 frames"),
        ((*SHED[:6], "--name", "森" * 90), "a landmark cannot be called"),
        ((*SHED, "--which", "99,3"), "frame 99 does not exist, recording 'monday' has frames 0 to 39; choose"),
        ((*SHED, "--which", "1e300,3"), "--which '1e300,3': a frame is a number from 0"),
        ((*SHED, "--out", __file__ + "/x"), "test_teach.py/x cannot be made, .*test_teach.py is no folder"),
        ((*SHED, "--which", "1.5,3"), "--which '1.5,3': a frame is a number from 0"),
    ],
)
def test_faults(options, message, drive, finder, andante, fails, tmp_path):
    fails(andante("teach", drive, "--out", tmp_path / "x", *options), message)
    assert not (tmp_path / "x").exists()


def test_three_frames_only(drive, anchor_scene, monkeypatch, andante, fails, tmp_path):
    monkeypatch.setattr("andante.cli.teach.anchor_finder", lambda weights: anchor_scene(found=range(3)))
    answer = andante("teach", drive, *SHED, "--out", tmp_path / "x")
    fails(answer, "the bicycle was found in 3 frames only, at least 10 are needed; drive nearer")


def test_one_frame(anchor_scene, finder, andante, fails, tmp_path):
    (frame, *_) = anchor_scene.recording().frames([0], colour=True)
    write_recording(tmp_path / "one", [frame], name="one", camera=anchor_scene.recording().camera)
    fails(
        andante("teach", tmp_path / "one", *SHED), "recording 'one' has 1 frame, an anchor has to be found in at least"
    )
    assert finder.searched == []


def test_two_anchors_of_one_class(drive, monkeypatch, andante, fails, tmp_path):
    def red_and_blue(picture, min_score):
        """What is red, and what is blue as the shed."""
        blue, green, red = picture.transpose(2, 0, 1).astype(int)
        found = []
        for mask in ((red > 160) & (green < 90), (blue > 130) & (green < 110) & (red < 70)):
            rows, columns = np.nonzero(mask)
            if len(rows) > 60:
                pixels = columns.min(), rows.min(), columns.max() + 1, rows.max() + 1
                found.append(Found(tuple(map(float, pixels)), "bicycle", 0.8))
        return found

    monkeypatch.setattr("andante.cli.teach.anchor_finder", lambda weights: AnchorSearch(red_and_blue, workers=1))
    message = r"two things called 'bicycle' are in view, in frame \d+ at azimuths .* \(--which (\d+,-?\d+)\), or take"
    answer = andante("teach", drive, *SHED, "--out", tmp_path / "x")
    fails(answer, message)
    which = re.search(message, answer.stderr)[1]
    chosen = andante("teach", drive, *SHED, "--which", which, "--out", tmp_path / "x", "--json")
    assert chosen.exit_code == 0, chosen.stderr


def test_beside_what(drive, andante, tmp_path):
    answer = andante("teach", drive, *SHED[2:], "--out", tmp_path / "x")
    assert answer.exit_code == 2
    assert "--anchor" in answer.stderr


def test_a_detector_that_is_none(drive, andante, fails, tmp_path):
    pytest.importorskip("onnx", reason="making a detector of other classes needs onnx")
    path = Path(__file__).parents[1] / "landmarks" / "yolox_files.py"
    spec = importlib.util.spec_from_file_location("yolox_files", path)
    yolox_files = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(yolox_files)
    write_yolox, table = yolox_files.write_yolox, yolox_files.table
    weights = tmp_path / "weights.onnx"
    weights.write_bytes(b"no network")
    other = write_yolox(tmp_path / "other.onnx", table({}, columns=25))
    message = "other.onnx knows 20 classes, not the 80 of COCO; give one that learnt from COCO"
    fails(andante("teach", drive, *SHED, "--out", tmp_path / "x", "--weights", other), message)
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
