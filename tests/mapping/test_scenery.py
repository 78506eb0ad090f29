"""Views imagined from where nobody drove, in a garden of posts whose distances are known."""

from dataclasses import replace

import numpy as np
import pytest
from tests.conftest import Garden

from andante.features import PhaseEncoder
from andante.mapping.codes import Codes
from andante.mapping.off_path import try_views
from andante.mapping.scenery import Drives, Scenery
from andante.mapping.stereo import COLUMNS, column_at, described, most_shift, shift_between, sweep

ENCODER = PhaseEncoder(24, 300, (2.0, 42.0))
RADIUS_M = 0.4


def signatures(garden, poses, gain=1.0, offset=0.0):
    """What the encoder makes of panoramas (24, 300) from 2 to 42 degrees."""
    whole = [garden.look(pose, 252, 300, 42.0, gain, offset) for pose in poses]
    low = [np.asarray(one[:240].reshape(24, 10, 300).mean(axis=1), np.uint8) for one in whole]
    return ENCODER.encode(np.stack(low))


def lap(n, radius_m=3.0, start=0.0):
    """Poses (n, 3) around a circle, each looking ahead."""
    angle = start + 2 * np.pi * np.arange(n) / n
    return np.column_stack([radius_m * np.cos(angle), radius_m * np.sin(angle), angle + np.pi / 2])


def drives(garden, *laps):
    phase = np.concatenate([signatures(garden, one) for one in laps])
    session = np.repeat(np.arange(len(laps)), [len(one) for one in laps])
    return Drives(ENCODER, Codes.of(phase), np.concatenate(laps), session, RADIUS_M)


@pytest.fixture(scope="module")
def garden():
    return Garden(3, posts=60)


@pytest.fixture(scope="module")
def scenery(garden):
    return Scenery.fit(drives(garden, lap(60)))


def inside(n, seed=1):
    """Poses within 2 m of the middle, at least a metre off the lap."""
    rng = np.random.default_rng(seed)
    distance, angle = 2 * np.sqrt(rng.uniform(size=n)), rng.uniform(-np.pi, np.pi, n)
    return np.column_stack([distance * np.cos(angle), distance * np.sin(angle), rng.uniform(-np.pi, np.pi, n)])


def test_spots_inside_of_a_lap_are_found_with_their_headings(garden, scenery):
    poses = inside(40)
    spots = [scenery.search(one) for one in signatures(garden, poses, gain=0.8, offset=10)]
    error = [np.hypot(spot.x_m - x, spot.y_m - y) for spot, (x, y, _) in zip(spots, poses, strict=True)]
    turn = [abs(np.mod(s.heading_rad - h + np.pi, 2 * np.pi) - np.pi) for s, h in zip(spots, poses[:, 2], strict=True)]
    assert np.median(error) < 0.15
    assert max(error) < 0.5
    assert np.median(turn) < np.radians(1)


def test_nothing_less_alike_than_asked_for_is_a_spot(garden, scenery):
    (one,) = signatures(garden, inside(1))
    spot = scenery.search(one)
    assert scenery.search(one, spot.alike - 1e-6) == spot
    assert scenery.search(one, spot.alike + 1e-3) is None


def test_mirror_images_and_other_gardens_are_less_alike(garden, scenery):
    own = [scenery.search(one) for one in signatures(garden, inside(20))]
    foreign = [scenery.search(one) for one in signatures(Garden(8, posts=60), inside(20))]
    assert np.median([spot.alike / spot.alike_mirrored for spot in own]) > 1.3
    assert max(spot.alike / spot.alike_mirrored for spot in foreign) < 1.4
    assert np.quantile([spot.alike for spot in own], 0.1) > max(spot.alike for spot in foreign)


def test_the_same_drives_give_the_same_scenery_which_files_keep(garden, scenery):
    again = Scenery.fit(drives(garden, lap(60)))
    for name, array in scenery.to_arrays().items():
        np.testing.assert_array_equal(array, again.to_arrays()[name])
    restored = Scenery.from_arrays(ENCODER, scenery.to_arrays())
    (one,) = signatures(garden, inside(1))
    assert restored.search(one) == scenery.search(one)


def test_headings_are_needed_and_a_way(garden):
    known = drives(garden, lap(60))
    poses = known.poses.copy()
    poses[:, 2] = np.nan
    assert Scenery.fit(replace(known, poses=poses)) is None
    assert Scenery.fit(known.subset(np.arange(4))) is None
    poses = np.tile(known.poses[:1], (60, 1))
    assert Scenery.fit(replace(known, poses=poses)) is None  # from one spot all distances look the same


@pytest.mark.parametrize("laps", [1, 2])
def test_what_is_promised_of_views_holds(garden, laps):
    mapped = drives(garden, *(lap(60, 3.0 + 0.05 * one, 0.1 * one) for one in range(laps)))
    bounds, scenery = try_views(mapped, coverage=0.9), Scenery.fit(mapped)
    poses = inside(40, seed=2)
    spots = [scenery.search(one) for one in signatures(garden, poses)]
    found = [(spot, pose) for spot, pose in zip(spots, poses, strict=True) if bounds.found(spot)]
    assert len(found) > 20
    covered = [np.hypot(spot.x_m - x, spot.y_m - y) <= bounds.radius_m(spot) for spot, (x, y, _) in found]
    assert np.mean(covered) > 0.8


def test_the_distances_of_posts_are_seen():
    """One post alone, at 2 m from the middle of a straight drive."""
    lonely = Garden(0, posts=1)
    lonely._xy, lonely._width, lonely._height = np.array([[0.0, 2.0]]), np.array([0.3]), np.array([1.5])
    poses = np.column_stack([np.arange(-2, 2.01, 0.4), np.zeros(11), np.zeros(11)])
    pictures = ENCODER.pictures(signatures(lonely, poses), COLUMNS)
    ranges = sweep(ENCODER, pictures, poses[:, :2], RADIUS_M)
    left = column_at(np.array([np.pi / 2]))[0]
    assert ranges.distance_m[5, left] == pytest.approx(2.0, rel=0.15)
    assert ranges.weight[5, left] > 0.1


def test_what_comes_nearer_moves_up_and_out_of_bounds_it_stops():
    step = ENCODER.band_step
    away = np.array([1.0, np.exp(step), np.exp(-2 * step), np.exp(40 * step)])
    most = most_shift(ENCODER)
    assert shift_between(ENCODER, np.ones(4), away).tolist() == [0, -1, 2, -most]
    unknown = PhaseEncoder(24, 300)
    assert most_shift(unknown) == 0
    assert not shift_between(unknown, np.ones(4), away).any()


def test_described_columns_know_their_neighbours_and_have_length_one():
    pictures = np.random.default_rng(0).normal(size=(2, 5, COLUMNS)).astype(np.float32)
    looks = described(pictures)
    np.testing.assert_allclose(np.linalg.norm(looks, axis=2), 1, rtol=1e-5)
    column = np.concatenate([pictures[1, :, (7 + step) % COLUMNS] for step in (-1, 0, 1)])
    np.testing.assert_allclose(looks[1, 7], column / np.linalg.norm(column), rtol=1e-5)
    # Moved up by one band, what was below the top is at the top, and nothing comes in from below.
    up = described(pictures, 1).reshape(2, COLUMNS, 3, 5)[:, :, 1]
    assert (up[..., -1] == 0).all()
    np.testing.assert_allclose(up[..., 0] / up[..., 1], (pictures[:, 1] / pictures[:, 2]), rtol=1e-3)
