import json

import cv2
import numpy as np
import pytest

from andante.data import CameraSpec


def test_recording(garden, andante):
    answer = andante("info", garden.monday, "--json")
    assert answer.exit_code == 0
    values = answer.json
    assert (values["kind"], values["name"], values["frames"]) == ("recording", "monday", 40)
    assert values["duration_s"] == pytest.approx(39 / 5)
    side = 2 * np.sin(np.pi / 40)
    assert values["length_m"] == pytest.approx(39 * side)
    assert values["poses"] == {"reference": 40, "odometry": 0, "place": 0}
    assert values["conditions"] == {"light": 1.0}
    assert values["image_px"] == [120, 120]
    assert values["image_circle"]["declared"] is True
    assert values["hints"] == []


def test_recording_for_people(garden, andante):
    answer = andante("info", garden.no_poses)
    assert answer.exit_code == 0
    assert "declared" in answer.stdout
    assert "hint: no reference poses" in answer.stderr


def test_circle_is_found_where_it_is_not_declared(andante, write_drive, tmp_path):
    folder = write_drive(tmp_path / "undeclared", camera=CameraSpec())
    circle = andante("info", folder, "--json").json["image_circle"]
    assert circle["declared"] is False
    assert circle["confidence"] > 0.5
    assert circle["radius_px"] == pytest.approx(57, abs=1.5)
    assert circle["centre_px"] == pytest.approx([59.5, 59.5], abs=1)
    assert "found, confidence" in andante("info", folder).stdout


def test_faults_of_images_are_hints(andante, write_drive, tmp_path):
    folder = write_drive(tmp_path / "faulty")
    (folder / "images" / "000000.png").write_bytes(b"no picture")
    cv2.imwrite(str(folder / "images" / "000039.png"), np.zeros((60, 60), np.uint8))
    answer = andante("info", folder, "--json")
    assert answer.exit_code == 0
    assert len(answer.json["unreadable"]) == 2
    assert len(answer.json["hints"]) == 2


def test_no_circle_in_dark_images(andante, write_drive, tmp_path):
    folder = write_drive(tmp_path / "dark", camera=CameraSpec())
    for path in (folder / "images").iterdir():
        cv2.imwrite(str(path), np.zeros((120, 120), np.uint8))
    hints = " ".join(andante("info", folder, "--json").json["hints"])
    assert "no image circle was found" in hints
    assert "some images are dark" in hints


def test_map(garden, andante):
    values = andante("info", garden.map, "--json").json
    assert (values["kind"], values["bytes"]) == ("map", garden.map.stat().st_size)
    assert [one["name"] for one in values["recordings"]] == ["monday", "tuesday"]
    answer = andante("info", garden.map)
    assert answer.exit_code == 0
    assert "monday" in answer.stdout
    assert "light 0.8" in answer.stdout
    assert values["tells_heading"] is True
    assert values["compass_places"] > 5
    assert f"yes, from {values['compass_places']} places" in " ".join(answer.stdout.split())


def test_expected_errors(garden, andante, tmp_path, fails):
    fails(andante("info", tmp_path / "nothing"), "nothing cannot be read")
    fails(andante("info", tmp_path), "recording.toml is missing")
    (tmp_path / "text").write_text(json.dumps({"no": "map"}))
    fails(andante("info", tmp_path / "text"), "no map")


def test_pictures_are_of_maps_with_landmarks(garden, andante, fails, tmp_path):
    picture = tmp_path / "a.png"
    fails(
        andante("info", garden.monday, "--picture", picture), "is a recording; --picture draws the landmarks of a map"
    )
    message = "has no landmarks to draw; teach some with: andante teach"
    fails(andante("info", garden.map, "--picture", picture), message)
    assert not picture.exists()
