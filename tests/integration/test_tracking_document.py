"""The Python code in docs/tracking.md runs as it stands."""

import re
from pathlib import Path

import numpy as np

from andante.data import Frame, FrameInfo, Pose2D
from andante.mapping import build_map
from andante.recordings import write_recording

DOCUMENT = Path(__file__).parents[2] / "docs" / "tracking.md"


def with_odometry(drive):
    """The drive with an odometry that begins at zero."""
    first = drive.infos[0].reference
    for frame in drive.frames():
        pose, info = frame.info.reference, frame.info
        believed = Pose2D(pose.x_m - first.x_m, pose.y_m - first.y_m, pose.heading_rad)
        yield Frame(FrameInfo(info.index, "", info.timestamp_s, believed, pose), frame.image)


def test_its_code_runs(garden, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    friday = garden.another_day()
    write_recording("garden/sunday", with_odometry(friday), name="sunday", camera=friday.camera, image_format="png")
    build_map(garden.two_days()).save("garden.andante")
    blocks = re.findall(r"^```python\n(.*?)^```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, str(DOCUMENT), "exec"), names)
    assert len(capsys.readouterr().out.splitlines()) == len(friday.infos) + 1
    frame = names["frame_of"](7, np.zeros((12, 120), np.uint8), 3.0, (1.0, 2.0, 0.5))
    assert frame.info == FrameInfo(7, "", 3.0, odometry=Pose2D(1.0, 2.0, 0.5))
    assert (tmp_path / "report" / "report.html").is_file()
