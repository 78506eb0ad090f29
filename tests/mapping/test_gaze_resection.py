import numpy as np
import pytest

from andante.errors import ArrayError, LearningError
from andante.mapping.gaze_resection import resect

AREA = np.array([[-4.0, -4.0], [4.0, 4.0]])
FRAMES, K = 6, 12


@pytest.fixture
def things():
    """What regions of some frames look at: each of 72 things once."""
    return np.random.default_rng(3).uniform(-9, 9, (FRAMES, K, 2))


def sight(things, pose, seen, foreign=()):
    """Squared distances and azimuths of patches that show the things ``seen``; ``foreign`` ones look like others."""
    rng = np.random.default_rng(0)
    flat = things.reshape(-1, 2)
    squared = rng.uniform(20, 40, (len(seen), len(flat))).astype(np.float32)
    for row, thing in enumerate(seen):
        squared[row, (thing + 31) % len(flat) if row in foreign else thing] = 1.0
    towards = flat[list(seen)] - pose[:2]
    azimuth = np.arctan2(towards[:, 1], towards[:, 0]) - pose[2]
    return squared.reshape(len(seen), FRAMES, K), azimuth


@pytest.mark.parametrize("pose", [(0.4, -1.3, 0.7), (-2.2, 3.1, -2.9), (3.0, 0.0, 3.1)])
def test_known_things_tell_place_and_heading(things, pose):
    found = resect(*_arguments(things, *sight(things, pose, range(0, 72, 9))))
    assert np.linalg.norm(found.xy - pose[:2]) < 0.15
    assert abs(np.angle(np.exp(1j * (found.heading_rad - pose[2])))) < np.radians(3)
    assert found.agreement > 0.65


def test_wrong_matches_drop_out(things):
    pose = (0.4, -1.3, 0.7)
    found = resect(*_arguments(things, *sight(things, pose, range(0, 72, 8), foreign=(1, 4, 5))))
    assert np.linalg.norm(found.xy - pose[:2]) < 0.2
    assert (found.support[[1, 4, 5]] < 0.3).all()


def test_what_stands_nobody_knows_where_is_left_out(things):
    pose = (0.4, -1.3, 0.7)
    squared, azimuth = sight(things, pose, range(0, 72, 9))
    things[3, 4:] = np.nan
    assert np.isfinite(resect(squared, things, azimuth, AREA).xy).all()


def test_a_large_area_is_searched_more_coarsely(things):
    pose = (0.4, -1.3, 0.7)
    squared, azimuth = sight(things, pose, range(0, 72, 4))
    found = resect(squared, things, azimuth, 3 * AREA)
    assert np.linalg.norm(found.xy - pose[:2]) < 0.3


def test_bad_input(things):
    squared, azimuth = sight(things, (0, 0, 0), range(0, 72, 9))
    with pytest.raises(ArrayError, match=r"at least 3 patches with an azimuth each .* got shapes \(2, 6, 12\)"):
        resect(squared[:2], things, azimuth[:2], AREA)
    with pytest.raises(ArrayError, match=r"and \(6, 11, 2\)"):
        resect(squared, things[:, 1:], azimuth, AREA)
    with pytest.raises(LearningError, match=r"of no region it is known how far away it looks"):
        resect(squared, things * np.nan, azimuth, AREA)


def _arguments(things, squared, azimuth):
    return squared, things, azimuth, AREA
