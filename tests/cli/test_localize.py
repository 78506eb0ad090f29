import csv
import math
import shutil

import cv2
import numpy as np
import pytest

KEYS = {"x_m", "y_m", "heading_rad", "radius_m", "covariance", "status", "reason"}


def first_picture(recording):
    return recording / "images" / "000000.png"


def test_one_image(garden, andante):
    answer = andante("localize", garden.map, first_picture(garden.sunday), "--json")
    assert answer.exit_code == 0
    values = answer.json
    assert set(values) >= KEYS | {"image"}
    assert values["status"] in ("ok", "degraded")
    assert math.hypot(values["x_m"] - 1, values["y_m"]) < 0.3  # the loop begins at (1, 0)
    assert abs(math.degrees(values["heading_rad"])) < 3  # and the robot always looks along x
    assert values["covariance"][2][2] > 0


def test_one_image_for_people(garden, andante):
    answer = andante("localize", garden.map, first_picture(garden.sunday))
    assert answer.exit_code == 0
    assert all(word in answer.stdout for word in ("status", "x [m]", "heading [deg]", "90 % radius [m]", "reason"))


def test_covered_lens_is_lost_and_no_error(garden, andante, tmp_path):
    cv2.imwrite(str(tmp_path / "black.png"), np.zeros((120, 120), np.uint8))
    answer = andante("localize", garden.map, tmp_path / "black.png", "--json")
    assert answer.exit_code == 0
    assert answer.json["status"] == "lost"
    assert answer.json["x_m"] is None
    assert "lens covered" in answer.json["reason"]


@pytest.mark.parametrize("folder", [".", "images"], ids=["recording", "folder of images"])
def test_many_images(garden, andante, folder):
    answer = andante("localize", garden.map, garden.sunday / folder, "--json")
    assert answer.exit_code == 0
    assert set(answer.json) == {"estimates", "skipped"}
    estimates = answer.json["estimates"]
    assert len(estimates) == 40
    assert all(set(one) >= KEYS | {"image", "timestamp_s"} for one in estimates)
    times = [one["timestamp_s"] for one in estimates]
    assert times == sorted(times)
    images = [one["image"] for one in estimates]
    assert images == sorted(images)


def test_long_tables_show_both_ends(garden, andante):
    answer = andante("localize", garden.map, garden.sunday)
    assert answer.exit_code == 0
    shown = [f"{number:06d}.png" in answer.stdout for number in range(40)]
    assert shown == [True] * 10 + [False] * 20 + [True] * 10
    assert "... 20 more" in answer.stdout


def test_files(garden, andante, tmp_path):
    tum, table = tmp_path / "sunday.tum", tmp_path / "sunday.csv"
    answer = andante("localize", garden.map, garden.sunday, "--tum", tum, "--csv", table, "--json")
    estimates = answer.json["estimates"]
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert [row["image"] for row in rows] == [one["image"] for one in estimates]
    poses = [line for line in tum.read_text().splitlines() if not line.startswith("#")]
    assert len(poses) == sum(one["x_m"] is not None for one in estimates) > 0
    *_, qz, qw = np.array([line.split() for line in poses], dtype=float).T
    known = [one["heading_rad"] for one in estimates if one["x_m"] is not None]
    np.testing.assert_allclose(2 * np.arctan2(qz, qw), known, atol=1e-6)


def test_unreadable_images_are_told(garden, andante, tmp_path):
    folder = tmp_path / "images"
    shutil.copytree(garden.sunday / "images", folder)
    (folder / "000003.png").write_bytes(b"no picture")
    answer = andante("localize", garden.map, folder, "--json")
    assert answer.exit_code == 0
    assert [one["image"] for one in answer.json["skipped"]] == ["000003.png"]
    assert "000003.png" in andante("localize", garden.map, folder).stderr


def test_expected_errors(garden, andante, tmp_path, fails):
    picture = first_picture(garden.sunday)
    fails(andante("localize", tmp_path / "no.andante", picture), "no.andante cannot be read: No such file")
    text = tmp_path / "text.andante"
    text.write_text("this is no map, but it is long enough to be looked at " * 10)
    fails(andante("localize", text, picture), "text.andante is damaged or no map")
    fails(andante("localize", garden.map, tmp_path / "no.jpg"), "no.jpg does not exist")
    fails(andante("localize", garden.map, text), "text.andante")
    empty = tmp_path / "empty"
    empty.mkdir()
    fails(andante("localize", garden.map, empty), "holds no images")
    fails(andante("localize", garden.map, garden.sunday, "--csv", tmp_path / "no" / "a.csv"), "--csv .* does not exist")


def test_image_of_foreign_proportions(garden, andante, tmp_path, fails):
    cv2.imwrite(str(tmp_path / "wide.png"), np.full((60, 200), 99, np.uint8))
    fails(andante("localize", garden.map, tmp_path / "wide.png"), "200x60 px does not fit")


def test_files_need_many_images(garden, andante, tmp_path):
    answer = andante("localize", garden.map, first_picture(garden.sunday), "--tum", tmp_path / "a.tum")
    assert answer.exit_code == 2
    assert "--tum needs a folder" in answer.stderr
