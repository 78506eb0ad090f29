import csv
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.data import Estimate, FrameInfo, Status
from andante.errors import InputError
from andante.evaluation import LocalizedFrame, Run, write_csv, write_tum


def run_of(*estimates):
    frames = [
        LocalizedFrame(FrameInfo(i, f"images/{i}.jpg", 1.6e9 + i / 10), one, 0.0) for i, one in enumerate(estimates)
    ]
    return Run(tuple(frames))


def test_tum_holds_the_frames_with_a_pose(tmp_path):
    path = tmp_path / "run.tum"
    write_tum(path, run_of(Estimate(Status.OK, "", 1.5, -2.0), Estimate(Status.LOST, "no idea")))
    assert path.read_text().splitlines()[2:] == ["1600000000.0 1.500000 -2.000000 0 0 0 0.000000000 1.000000000"]
    comments = path.read_text().splitlines()[:2]
    assert all(line.startswith("# ") for line in comments)
    assert "unknown heading is the identity" in comments[1]


@given(st.floats(-math.pi, math.pi))
def test_tum_quaternions_turn_about_z(tmp_path_factory, heading):
    path = tmp_path_factory.mktemp("tum") / "run.tum"
    write_tum(path, run_of(Estimate(Status.DEGRADED, "", 0.0, 0.0, heading)))
    _, *_, qz, qw = np.loadtxt(path)
    turned = math.atan2(2 * qw * qz, 1 - 2 * qz**2)
    assert abs(math.remainder(turned - heading, 2 * math.pi)) < 1e-6


def test_tum_needs_metres(tmp_path):
    with pytest.raises(InputError, match=r"places have no position in metres.*CSV"):
        write_tum(tmp_path / "run.tum", run_of(Estimate(Status.OK, "", place=3)))
    assert list(tmp_path.iterdir()) == []


def test_csv_holds_all_frames_and_reads_back(tmp_path):
    path = tmp_path / "run.csv"
    said = 'several places look like this: "a, b"\nor c'
    write_csv(path, run_of(Estimate(Status.OK, "", 0.1, 2.0, 0.3, radius_m=0.4), Estimate(Status.LOST, said)))
    with path.open(newline="") as file:
        first, second = csv.DictReader(file)
    assert first == {
        "timestamp_s": "1600000000.0", "image": "images/0.jpg", "x_m": "0.1", "y_m": "2.0", "heading_rad": "0.3",
        "radius_m": "0.4", "status": "ok", "reason": "", "place": "",
    }  # fmt: skip
    assert second["reason"] == said
    assert second["x_m"] == second["radius_m"] == ""


@pytest.mark.parametrize("write", [write_tum, write_csv])
def test_a_place_that_cannot_be_written_is_one_line(tmp_path, write):
    with pytest.raises(InputError, match="cannot be written: No such file or directory; choose another place"):
        write(tmp_path / "nowhere" / "run", run_of())


def test_a_file_is_replaced_and_nothing_is_left_beside_it(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("old")
    write_csv(path, run_of())
    assert path.read_text().startswith("timestamp_s,")
    assert list(tmp_path.iterdir()) == [path]
