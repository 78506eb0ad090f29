import csv
from dataclasses import replace

import numpy as np
import pytest

from andante.data import Frame, Pose2D
from andante.recordings import open_recording, write_recording

KEYS = {
    "n", "median_m", "mean_m", "p95_m", "max_m", "share_over_1m", "share_over_3m", "heading_median_deg", "lost_share",
    "ms_per_image", "coverage_90", "confident_wrong_share",
}  # fmt: skip


@pytest.fixture(scope="module")
def with_odometry(garden, tmp_path_factory):
    """The drive of sunday with an odometry that begins at zero."""
    sunday = open_recording(garden.sunday)
    angles = np.linspace(0, 2 * np.pi, len(sunday.infos), endpoint=False)

    def frames():
        for frame, angle in zip(sunday.frames(), angles.tolist(), strict=True):
            # The robot of these drives never turns, and goes sideways.
            believed = Pose2D(float(np.cos(angle) - 1), float(np.sin(angle)), 0.0)
            yield Frame(replace(frame.info, odometry=believed), frame.image)

    folder = tmp_path_factory.mktemp("rides") / "ride"
    write_recording(folder, frames(), name="ride", camera=sunday.camera, image_format="png")
    return folder


@pytest.mark.parametrize("more", [(), ("--filter", "kalman"), ("--smooth",)])
def test_json_tells_all(garden, andante, with_odometry, more):
    answer = andante("track", garden.map, with_odometry, *more, "--json")
    assert answer.exit_code == 0, answer.stderr
    values = answer.json
    assert set(values) >= KEYS | {"recovery_frames", "recovery_worst_frames", "ms_filter", "single", "report"}
    assert set(values["single"]) >= KEYS
    assert values["n"] == values["single"]["n"] == 40
    assert values["mean_m"] < 0.5
    assert values["filter"] == ("kalman" if "kalman" in more else "particles")
    assert values["smoothed"] == ("--smooth" in more)


def test_table_and_files(garden, andante, with_odometry, tmp_path):
    tum, table, page = tmp_path / "ride.tum", tmp_path / "ride.csv", tmp_path / "report"
    answer = andante("track", garden.map, with_odometry, "--tum", tum, "--csv", table, "--report", page)
    assert answer.exit_code == 0, answer.stderr
    assert "ride: 40 frames with truth of 40" in answer.stdout
    assert "single images" in answer.stdout
    assert "particles" in answer.stdout
    assert answer.stderr == ""
    assert (page / "report.html").is_file()
    rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 40
    assert len(tum.read_text().splitlines()) == 2 + sum(row["x_m"] != "" for row in rows)


def test_without_odometry_it_is_said(garden, andante):
    answer = andante("track", garden.map, garden.sunday)
    assert answer.exit_code == 0, answer.stderr
    assert "hint: recording 'sunday' has no odometry (odom_x_m, odom_y_m in frames.csv): tracked by" in answer.stderr


def test_without_truth_there_are_only_statuses(garden, andante, tmp_path, write_drive):
    drive = write_drive(tmp_path / "unknown", seed=3, reference=False)
    answer = andante("track", garden.map, drive)
    assert answer.exit_code == 0, answer.stderr
    assert "unknown: 40 frames, particles" in " ".join(answer.stdout.split())
    assert "hint: no reference poses (x_m, y_m), so no errors are told" in answer.stderr
    values = andante("track", garden.map, drive, "--json").json
    assert (values["n"], values["mean_m"], values["recovery_frames"], values["single"]["mean_m"]) == (
        0,
        None,
        None,
        None,
    )


def test_a_state_is_used_and_saved(garden, andante, with_odometry, tmp_path):
    state = tmp_path / "robot.state"
    first = andante("track", garden.map, with_odometry, "--state", state, "--json")
    assert first.exit_code == 0, first.stderr
    assert state.is_file()
    # The same frames once more are old news: the tracker stays where it was.
    again = andante("track", garden.map, with_odometry, "--state", state, "--json")
    assert again.exit_code == 0, again.stderr
    assert again.json["mean_m"] > first.json["mean_m"]


def test_training_data_is_refused_unless_asked_for(garden, andante, fails):
    fails(andante("track", garden.map, garden.monday), "learnt from recording 'monday'")
    answer = andante("track", garden.map, garden.monday, "--training-error")
    assert answer.exit_code == 0
    assert "hint: training error" in answer.stderr


@pytest.mark.parametrize("as_json", [(), ("--json",)])
def test_expected_errors(garden, andante, tmp_path, fails, as_json):
    fails(andante("track", tmp_path / "no.andante", garden.sunday, *as_json), "no.andante cannot be read")
    fails(andante("track", garden.map, garden.sunday, "--report", garden.map, *as_json), "--report .* is a file")
    fails(andante("track", garden.map, garden.sunday, "--tum", tmp_path / "a" / "b", *as_json), "--tum .* not exist")
    fails(andante("track", garden.map, garden.sunday, "--state", tmp_path, *as_json), "--state .* is a folder")
    (tmp_path / "state").write_text("nothing")
    fails(andante("track", garden.map, garden.sunday, "--state", tmp_path / "state", *as_json), "tracker state")


def test_wrong_usage(garden, andante):
    assert andante("track", garden.map, garden.sunday, "--filter", "magic").exit_code == 2
    assert andante("track", garden.map).exit_code == 2


def test_help_teaches(andante):
    text = " ".join(andante("track", "--help").stdout.split())
    for word in ("degraded", "off_map", "--filter", "--state", "odom_x_m"):
        assert word in text
