import cv2
import numpy as np
import pytest

from andante.data import CameraSpec, Pose2D
from andante.errors import ConfigError, RecordingError
from andante.recordings import open_images


@pytest.fixture
def folder(tmp_path):
    pictures = tmp_path / "walk"
    pictures.mkdir()
    for index in (1, 2, 10):
        cv2.imwrite(str(pictures / f"img{index}.png"), np.full((4, 6), index, np.uint8))
    return pictures


def test_natural_order_one_second_apart(folder):
    (folder / "notes.txt").write_text("not an image")
    (folder / ".img0.png").write_text("hidden")
    (folder / "img3.png").mkdir()
    recording = open_images(folder)
    assert [info.image for info in recording.infos] == ["img1.png", "img2.png", "img10.png"]
    assert [info.timestamp_s for info in recording.infos] == [0.0, 1.0, 2.0]
    assert [int(frame.image[0, 0]) for frame in recording.frames()] == [1, 2, 10]
    assert (recording.name, recording.camera) == ("walk", CameraSpec())


@pytest.mark.parametrize("gap", [",", ";", "\t", " ", "   "])
def test_a_table_in_other_words(folder, tmp_path, gap):
    rows = [["stamp", "file", "east", "north", "speed"], ["1500", "img1.png", "1", "2", "9"]]
    rows.append(["2500", "img10.png", "3", "4", "9"])
    table = tmp_path / "table.txt"
    table.write_text("\n".join(gap.join(row) for row in rows) + "\n")
    columns = {"timestamp_s": "stamp", "image": "file", "x_m": "east", "y_m": "north"}
    camera = CameraSpec(model="panorama")
    recording = open_images(folder, table, columns=columns, camera=camera, name="tuesday", time_unit="ms")
    assert [info.timestamp_s for info in recording.infos] == [1.5, 2.5]
    assert [info.reference for info in recording.infos] == [Pose2D(1, 2), Pose2D(3, 4)]
    assert [int(frame.image[0, 0]) for frame in recording.frames()] == [1, 10]
    assert (recording.name, recording.camera) == ("tuesday", camera)


def test_a_table_in_our_words_with_more_columns(folder, tmp_path):
    (tmp_path / "t.csv").write_text("timestamp_s,image,speed\n0,img1.png,3\n")
    assert len(open_images(folder, tmp_path / "t.csv").infos) == 1


@pytest.mark.parametrize(("unit", "ticks"), [("s", 1), ("ms", 10**3), ("us", 10**6), ("ns", 10**9)])
def test_units_of_time(folder, tmp_path, unit, ticks):
    (tmp_path / "t.csv").write_text(f"timestamp_s,image\n{ticks},img1.png\n{3 * ticks},img2.png\n")
    infos = open_images(folder, tmp_path / "t.csv", time_unit=unit).infos
    assert [info.timestamp_s for info in infos] == [1.0, 3.0]


def test_faults(folder, tmp_path):
    with pytest.raises(RecordingError, match="nowhere does not exist or is no folder"):
        open_images(tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    with pytest.raises(RecordingError, match=r"empty holds no images; looked for \.jpg"):
        _ = open_images(tmp_path / "empty").infos
    with pytest.raises(ConfigError, match="time unit 'h' is unknown; allowed are s, ms, us, ns"):
        open_images(folder, time_unit="h")
    with pytest.raises(ConfigError, match="unknown name 'time'; allowed are timestamp_s"):
        open_images(folder, "t.csv", columns={"time": "stamp"})
    with pytest.raises(ConfigError, match="'image' is missing; say which column"):
        open_images(folder, "t.csv", columns={"timestamp_s": "stamp"})
    (tmp_path / "t.csv").write_text("stamp,file\n0,img1.png\n")
    with pytest.raises(RecordingError, match="no column 'stamps' for timestamp_s; found stamp, file"):
        _ = open_images(folder, tmp_path / "t.csv", columns={"timestamp_s": "stamps", "image": "file"}).infos
    (tmp_path / "t.csv").write_text("stamp,file\nnoon,img1.png\n")
    with pytest.raises(RecordingError, match="line 2, column stamp: 'noon' is not a finite number"):
        _ = open_images(folder, tmp_path / "t.csv", columns={"timestamp_s": "stamp", "image": "file"}).infos
    with pytest.raises(RecordingError, match=r"gone\.csv does not exist"):
        _ = open_images(folder, tmp_path / "gone.csv").infos
