import numpy as np
import pytest

from andante.data import Pose2D
from andante.errors import ConfigError, InputError
from andante.mapping import build_map
from andante.navigation import image_goal, named_goal, places_file, pose_goal


@pytest.fixture(scope="module")
def slowmap(garden):
    return build_map(garden.two_days())


def test_a_pose():
    assert pose_goal(1.0, -2.0).pose == Pose2D(1.0, -2.0, None)
    assert pose_goal(1.0, -2.0, 0.5).pose.heading_rad == 0.5
    with pytest.raises(ConfigError, match=r"a goal needs finite numbers, got x nan"):
        pose_goal(float("nan"), 0.0)


def test_where_an_image_was_taken(slowmap, garden):
    pose = garden.loop(60)[20]
    goal = image_goal(slowmap, garden.panorama(pose, gain=0.9), "bench.jpg")
    assert np.hypot(goal.pose.x_m - pose[0], goal.pose.y_m - pose[1]) < 0.3
    assert goal.name == "bench.jpg"
    assert goal.slow.shape == (slowmap.model.output_dim,)


def test_an_image_that_the_map_does_not_know_is_no_goal(slowmap, garden):
    with pytest.raises(InputError, match=r"the goal image is (lost|off map): .*; take one at a mapped place"):
        image_goal(slowmap, np.full_like(garden.panorama((0, 0, 0)), 128))


def test_places_have_names(tmp_path):
    places_file(tmp_path / "garden.andante").write_text("charging-station = [1.5, -2, 0.5]\npond = [3, 4]\n")
    assert named_goal(tmp_path / "garden.andante", "charging-station").pose == Pose2D(1.5, -2.0, 0.5)
    assert named_goal(tmp_path / "garden.andante", "pond").pose == Pose2D(3.0, 4.0, None)


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        (None, InputError, r"named places .*garden.places.toml cannot be read: .*; write it with lines such as"),
        ("pond = [1", ConfigError, r"no valid TOML"),
        ("pond = [1]", ConfigError, r"pond = \[1\] is not allowed; give \[x_m, y_m\]"),
        ("pond = 'far'", ConfigError, r"pond = 'far' is not allowed"),
        ("pond = [nan, 1]", ConfigError, r"finite"),
        ("", ConfigError, r"there is no place 'pond' in .*; it has none"),
    ],
)
def test_what_is_wrong_with_named_places(tmp_path, text, error, message):
    if text is not None:
        places_file(tmp_path / "garden.andante").write_text(text)
    with pytest.raises(error, match=message):
        named_goal(tmp_path / "garden.andante", "pond")
