"""What users really hand in: from a folder with a fault to one line that says what to do.

Every test walks the whole path, from files on the disk to a map, and reads the message that the command line prints.
"""

import shutil
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from andante import MapConfig, Pose2D, SlowMap, build_map, open_recording, read_image
from andante.errors import AndanteError, ConfigError, ImageError, LearningError, RecordingError

FRAMES = 40
PANORAMA_TOML = 'schema = 1\nname = "monday"\n[camera]\nmodel = "panorama"\n'
FISHEYE_TOML = 'schema = 1\nname = "monday"\n[camera]\ncentre_px = [39.5, 39.5]\nradius_px = 39.0\n'
CONFIG = MapConfig().with_values({"learning": {"slow_features": 10}})

MakeFolder = Callable[..., Path]


def landscape(x: float, y: float, height: int = 10, width: int = 60) -> np.ndarray:
    """A panorama that changes smoothly with the place: twelve posts on the horizon."""
    rng = np.random.default_rng(3)
    posts, levels, tops = rng.uniform(-6, 6, (12, 2)), rng.uniform(-80, 100, 12), rng.uniform(0.2, 0.9, 12)
    azimuth = np.pi - 2 * np.pi * (np.arange(width) + 0.5) / width
    down = (np.arange(height) + 0.5) / height
    to_post = posts - (x, y)
    distance = np.hypot(*to_post.T) + 0.3
    turn = np.angle(np.exp(1j * (np.arctan2(to_post[:, 1], to_post[:, 0])[:, None] - azimuth)))
    across = np.exp(-0.5 * (turn * distance[:, None] / 0.5) ** 2)
    upright = 1 / (1 + np.exp((1 - down - tops[:, None] / distance[:, None] * 2) / 0.1))
    return np.clip(120 + np.einsum("n,nh,nw->hw", levels, upright, across), 0, 255).astype(np.uint8)


def position(index: int) -> tuple[float, float]:
    turn = 2 * np.pi * index / FRAMES
    return 3 * np.cos(turn), 2 * np.sin(turn)


def table(n: int = FRAMES, header: str = "timestamp_s,image,x_m,y_m", **cells: str) -> str:
    """``frames.csv`` of n frames; ``r5="..."`` replaces the row of frame 5."""
    rows = [f"{0.2 * i:.3f},images/{i:03d}.png,{position(i)[0]:.4f},{position(i)[1]:.4f}" for i in range(n)]
    for key, row in cells.items():
        rows[int(key[1:])] = row
    return "\n".join([header, *rows])


@pytest.fixture
def folder(tmp_path: Path) -> MakeFolder:
    """``folder(n, toml=..., csv=...)`` -> a recording of a small panorama camera, sound where nothing else is said."""

    def make(n: int = FRAMES, *, toml: str = PANORAMA_TOML, csv: str | None = None, name: str = "monday") -> Path:
        path = tmp_path / name
        (path / "images").mkdir(parents=True)
        for i in range(n):
            picture = landscape(*position(i)) if "panorama" in toml else np.full((80, 80), 90, np.uint8)
            assert cv2.imwrite(str(image(path, i)), picture)
        (path / "recording.toml").write_text(toml.replace("monday", name), encoding="utf-8")
        (path / "frames.csv").write_text(table(n) if csv is None else csv, encoding="utf-8")
        return path

    return make


def image(path: Path, index: int) -> Path:
    return path / "images" / f"{index:03d}.png"


def mapped(*paths: Path, config: MapConfig = CONFIG) -> SlowMap:
    return build_map([open_recording(path) for path in paths], config)


def complaint(kind: type[AndanteError], *paths: Path, config: MapConfig = CONFIG) -> str:
    """The message of the error with which a map of these recordings fails."""
    with pytest.raises(kind) as caught:
        mapped(*paths, config=config)
    message = str(caught.value)
    assert "\n" not in message
    assert 20 < len(message) < 900
    return message


def test_a_sound_recording_makes_a_map(folder):
    built = mapped(folder())
    estimate = built.localize(landscape(*position(7)))
    assert np.hypot(estimate.x_m - position(7)[0], estimate.y_m - position(7)[1]) < 0.3
    assert built.sources[0].skipped == ()


FAULTS = {
    "missing": lambda path: path.unlink(),
    "truncated": lambda path: path.write_bytes(path.read_bytes()[:-40]),
    "empty": lambda path: path.write_bytes(b""),
    "text": lambda path: path.write_text("this is no picture"),
    "constant": lambda path: cv2.imwrite(str(path), np.full((10, 60), 77, np.uint8)),
    "black": lambda path: cv2.imwrite(str(path), np.zeros((10, 60), np.uint8)),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_up_to_one_image_in_twenty_may_be_faulty(folder, fault):
    path = folder()
    for index in (0, 21):
        FAULTS[fault](image(path, index))
    built = mapped(path)
    assert built.sources[0].frames == FRAMES - 2
    assert len(built.sources[0].skipped) == 2
    for index, reason in zip((0, 21), built.sources[0].skipped, strict=True):
        assert f"images/{index:03d}.png" in reason
        assert "\n" not in reason


@pytest.mark.parametrize("fault", FAULTS)
def test_more_faulty_images_are_too_many(folder, fault):
    path = folder()
    for index in (0, 11, 32):
        FAULTS[fault](image(path, index))
    message = complaint(RecordingError, path)
    assert "recording 'monday': 3 of the first" in message
    assert "images cannot be used, at most 5% of 40 may be skipped" in message


def test_constant_images_only(folder):
    path = folder()
    for index in range(FRAMES):
        FAULTS["constant"](image(path, index))
    assert "the image shows nothing" in complaint(RecordingError, path)


def test_images_of_mixed_size(folder):
    path = folder()
    cv2.imwrite(str(image(path, 9)), landscape(*position(9), 12, 64))
    message = complaint(RecordingError, path)
    assert "images of mixed size, images/000.png is 60 x 10 and images/009.png is 64 x 12 pixels" in message


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ("0.8,images/005.png,1,1", "line 7: times must increase, line 7 has 0.8 s after 0.8 s in line 6"),
        ("0.1,images/005.png,1,1", "times must increase, line 7 has 0.1 s after 0.8 s in line 6; sort the frames"),
        ("nan,images/005.png,1,1", "line 7, column timestamp_s: 'nan' is not a finite number"),
        (",images/005.png,1,1", "line 7, column timestamp_s: is blank; every frame needs a time"),
        ("1.0,images/005.png,NaN,1", "line 7, column x_m: 'NaN' is not a finite number; give one or leave the cell"),
        ("1.0,images/005.png,1,inf", "line 7, column y_m: 'inf' is not a finite number"),
        ("1.0,images/005.png,about 3,1", "line 7, column x_m: 'about 3' is not a finite number"),
        ("1.0,images/005.png,1,", "line 7, column y_m: is blank beside other values of this pose"),
        ("1.0,images/005.png,1", "line 7: 3 cells, the header has 4"),
        ("1.0,,1,1", "line 7, column image: is blank"),
        ("1.0,../secret.png,1,1", "line 7, column image: '../secret.png' leads out of the recording"),
        ("1.0,/etc/passwd,1,1", "line 7, column image: '/etc/passwd' leads out of the recording"),
        ("1.0,images/../../x.png,1,1", "leads out of the recording"),
    ],
)
def test_faulty_rows_name_line_and_column(folder, row, expected):
    message = complaint(RecordingError, folder(csv=table(r5=row)))
    # Times are compared over the whole table, so that message names both lines itself.
    assert expected.removeprefix("line 7: ") in message
    assert "frames.csv" in message


def test_a_link_out_of_the_recording_is_not_followed(folder, tmp_path):
    path = folder()
    outside = tmp_path / "outside.png"
    shutil.move(image(path, 5), outside)
    image(path, 5).symlink_to(outside)
    assert "image images/005.png is a link out of the folder" in complaint(RecordingError, path)


def test_no_poses_at_all(folder):
    rows = "\n".join(["timestamp_s,image", *(f"{i}.0,images/{i:03d}.png" for i in range(FRAMES))])
    message = complaint(RecordingError, folder(csv=rows))
    assert "has neither reference poses, places nor odometry" in message
    assert "needs x_m and y_m, place, or odom_x_m and odom_y_m in frames.csv" in message


def test_a_header_in_other_words(folder):
    message = complaint(RecordingError, folder(csv=table(header="time,image,x_m,y_m")))
    assert "unknown column 'time'; allowed are timestamp_s, image" in message


@pytest.mark.parametrize("missing", ["recording.toml", "frames.csv"])
def test_a_recording_that_lacks_a_file(folder, missing):
    path = folder()
    (path / missing).unlink()
    assert f"{missing} is missing; a recording is a folder with" in complaint(RecordingError, path)


def test_no_recording_at_all(tmp_path):
    assert "does not exist" in complaint(RecordingError, tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("toml", "expected"),
    [
        (PANORAMA_TOML.replace("panorama", "telescope"), "camera.model"),
        (PANORAMA_TOML + "zoom = 3\n", "unknown key 'camera.zoom'; allowed are model"),
        (PANORAMA_TOML + "forward_deg = nan\n", "camera.forward_deg"),
        (PANORAMA_TOML.replace("schema = 1", "schema = 2"), "schema 2 is newer than this version"),
        ("schema = ", "not valid TOML"),
    ],
)
def test_a_faulty_description(folder, toml, expected):
    path = folder()
    (path / "recording.toml").write_text(toml, encoding="utf-8")
    assert expected in complaint(RecordingError, path)


@pytest.mark.parametrize("n", [1, 2, 3, 9])
def test_too_few_frames_to_learn_from(folder, n):
    assert f"{n} usable frames are too few to learn from" in complaint(LearningError, folder(n), config=MapConfig())


def test_fewer_frames_than_components_are_a_small_map(folder):
    built = mapped(folder(15), config=MapConfig())
    assert built.model.output_dim == 14
    assert built.localize(landscape(*position(4))).status.has_pose


def test_a_quadratic_map_says_how_many_frames_it_needs(folder):
    message = complaint(LearningError, folder(20), config=MapConfig.thesis())
    assert "20 usable frames are too few to learn from, at least 28 are needed; record a longer drive" in message


def test_a_polynomial_says_how_many_frames_it_needs(folder):
    config = MapConfig().with_values({"readout": {"kind": "polynomial", "degree": 3}})
    message = complaint(LearningError, folder(), config=config)
    assert "a polynomial of degree 3 in 8 slow features has 165 terms, but there are 40 frames; lower" in message


@pytest.mark.parametrize("components", [0, 256])
def test_a_robot_that_drives_while_its_picture_stands_still(folder, components):
    path = folder()
    for index in range(1, FRAMES):
        shutil.copy(image(path, 0), image(path, index))
    config = MapConfig().with_values({"learning": {"pca_components": components}})
    message = complaint(LearningError, path, config=config)
    assert "all samples are the same" in message or "signals varies over the 40 samples" in message


def test_a_robot_that_never_moves(folder):
    still = [f"{0.2 * i:.3f},images/{i:03d}.png,1.0,1.0" for i in range(FRAMES)]
    message = complaint(LearningError, folder(csv="\n".join(["timestamp_s,image,x_m,y_m", *still])))
    assert "1 usable frames are too few" in message


def test_recordings_of_different_cameras(folder):
    fisheye = folder(toml=FISHEYE_TOML, name="up")
    for index in range(FRAMES):
        picture = np.zeros((80, 80), np.uint8)
        cv2.circle(picture, (40, 40), 39, 90 + index, -1)
        cv2.imwrite(str(image(fisheye, index)), picture)
    message = complaint(ConfigError, folder(), fisheye)
    assert "this map was made from panorama images giving panoramas of 60x10, the new fisheye camera gives" in message
    assert "use a camera like the map's" in message


def test_the_same_recording_twice(folder):
    path = folder()
    assert "'monday' and 'monday' have the same content; leave one out" in complaint(RecordingError, path, path)


def test_a_camera_that_sees_nothing_of_the_panorama(folder):
    toml = FISHEYE_TOML.replace("39.5, 39.5", "5000.0, 5000.0")
    assert "the camera sees nothing between 3 and 35 degrees of elevation" in complaint(ConfigError, folder(toml=toml))


def test_elevations_the_wrong_way_round(folder):
    config = MapConfig().with_values({"panorama": {"min_deg": 40.0, "max_deg": 20.0}})
    assert "min_deg 40 and max_deg 20" in complaint(ConfigError, folder(), config=config)


def bomb(side: int) -> bytes:
    """A PNG of a few kilobytes that declares side x side pixels."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    pixels = zlib.compress(bytes(1_000_000))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def test_a_decompression_bomb_is_not_decompressed(folder, tmp_path):
    path = folder()
    for index in (3, 4, 5):
        image(path, index).write_bytes(bomb(50_000))
    assert "declares 50000 x 50000 pixels, at most 64 megapixels are decoded" in complaint(RecordingError, path)
    with pytest.raises(ImageError, match="at most 64 megapixels are decoded; scale it down"):
        read_image(image(path, 3))


def test_an_image_of_another_camera_is_refused_by_the_map(folder, tmp_path):
    built = mapped(folder())
    with pytest.raises(ImageError, match="an image of 80x80 px does not fit the camera, whose images are 60x10 px"):
        built.localize(np.zeros((80, 80), np.uint8))


def test_one_missing_picture_in_a_long_drive_does_not_stop_the_search_for_the_circle(tmp_path):
    """The circle is sought in a dozen pictures; one of them may be among the five per cent."""
    from andante.data import CameraSpec, Frame, FrameInfo
    from andante.recordings import write_recording

    rng = np.random.default_rng(0)
    y, x = np.mgrid[:80, :80]
    inside = np.hypot(x - 39.5, y - 39.5) <= 37

    def frames():
        for i in range(FRAMES):
            texture = cv2.resize(landscape(*position(i), 8, 8), (80, 80), interpolation=cv2.INTER_CUBIC)
            picture = np.where(inside, np.clip(texture.astype(int) + rng.integers(60, 70), 60, 255), 0)
            pose = Pose2D(*position(i))
            yield Frame(FrameInfo(i, "", 0.2 * i, reference=pose), picture.astype(np.uint8))

    recording = write_recording(tmp_path / "up", frames(), name="up", camera=CameraSpec(), image_format="png")
    (tmp_path / "up" / recording.infos[0].image).unlink()
    built = mapped(tmp_path / "up")
    assert built.sources[0].frames == FRAMES - 1
    assert built.front_end.camera.radius_px == pytest.approx(37, abs=1.5)
