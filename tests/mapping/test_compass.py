"""Headings and places from phases, against panoramas that are really turned and correlations that are really summed."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.errors import ArrayError
from andante.features import PhaseEncoder
from andante.mapping.codes import Codes
from andante.mapping.compass import BLENDED, CLEAR, ELSEWHERE_RAD, SAMPLES, Compass

HEIGHT, WIDTH, PLACES = 12, 120, 30
ENCODER = PhaseEncoder(HEIGHT, WIDTH)
CELL_M = 0.5


def panoramas(count: int, seed: int = 0) -> np.ndarray:
    """(count, 12, 120) uint8: smooth and without a seam."""
    rough = np.random.default_rng(seed).normal(size=(count, HEIGHT, WIDTH)).astype(np.float32)
    around = [cv2.GaussianBlur(np.tile(one, 3), (0, 0), 2.5)[:, WIDTH : 2 * WIDTH] for one in rough]
    return np.stack([np.clip(128 + 40 * one / one.std(), 0, 255) for one in around]).astype(np.uint8)


@pytest.fixture(scope="module")
def places() -> tuple[np.ndarray, np.ndarray]:
    """Signatures (30, p) at heading zero and positions (30, 2), each in a cell of its own."""
    grid = np.stack(np.meshgrid(np.arange(6), np.arange(5)), axis=2).reshape(-1, 2)
    return ENCODER.encode(panoramas(PLACES)), 2.0 * grid


@pytest.fixture(scope="module")
def compass(places) -> Compass:
    """Of frames that were mapped under all kinds of headings."""
    signatures, xy = places
    heading = np.linspace(-3, 9, PLACES)
    return fitted(ENCODER.turned(signatures, heading), xy, heading)


def fitted(signatures: np.ndarray, xy: np.ndarray, heading: np.ndarray) -> Compass:
    built = Compass.fit(ENCODER, Codes.of(signatures), xy, heading, CELL_M)
    assert built is not None
    return built


def off_deg(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    return np.abs(np.degrees(np.mod(found - truth + np.pi, 2 * np.pi) - np.pi))


def curve_by_rolling(seen: np.ndarray, stored: np.ndarray) -> np.ndarray:
    """How alike two signatures are under each of 256 turns: bands drawn, rolled column by column, multiplied."""
    drawn = []
    for signature in (seen, stored):
        spectra = np.zeros((ENCODER.bands, SAMPLES // 2 + 1), complex)
        spectra[:, 1 : ENCODER.frequencies + 1] = ENCODER.spectra(signature[None])[0]
        drawn.append(np.fft.irfft(spectra, SAMPLES, axis=1))
    image, reference = drawn
    return np.array([(image * np.roll(reference, turn, axis=1)).sum() for turn in range(SAMPLES)]) * SAMPLES / 2


@given(st.floats(-10, 10), st.integers(0, PLACES - 1))
def test_the_heading_of_any_turn(places, compass, turn, place):
    signatures, xy = places
    image = ENCODER.turned(signatures[place : place + 1], np.array([turn]))
    found = compass.bearings(image, xy[place : place + 1])
    assert off_deg(found.heading, turn).item() < 0.1
    assert -np.pi <= found.heading.item() < np.pi
    assert found.peak.item() > 0.97
    assert found.rival.item() < 0.8


def test_panoramas_that_are_really_turned(compass, places):
    """To the left by so many columns: all moves to the right by as many."""
    pictures, xy = panoramas(PLACES), places[1]
    for columns in (0, 1, 17, 60, 119):
        rolled = np.roll(pictures, columns, axis=2)
        found = compass.bearings(ENCODER.encode(rolled), xy)
        assert off_deg(found.heading, 2 * np.pi * columns / WIDTH).max() < 0.1


def test_how_alike_is_what_rolling_gives(places, compass):
    """At a place far from all others, of which only it counts."""
    signatures, xy = places
    images = ENCODER.turned(signatures, np.linspace(0, 5, PLACES)) + np.float32(0.02) * np.random.default_rng(1).normal(
        size=signatures.shape
    ).astype(np.float32)
    found = compass.bearings(images, xy)
    stored = compass.codes.rows()
    for row in range(0, PLACES, 5):
        place = np.linalg.norm(compass.xy - xy[row], axis=1).argmin()
        curve = curve_by_rolling(images[row], stored[place] / np.linalg.norm(stored[place]))
        at = curve.argmax()
        assert found.peak[row] == pytest.approx(curve[at], abs=1e-5)
        assert off_deg(found.heading[row], 2 * np.pi * at / SAMPLES) <= 0.5 * 360 / SAMPLES + 1e-6
        turns = 2 * np.pi * (np.arange(SAMPLES) - at) / SAMPLES
        apart = np.abs(np.arctan2(np.sin(turns), np.cos(turns)))
        assert found.rival[row] == pytest.approx(curve[apart > ELSEWHERE_RAD].max(), abs=1e-5)


def test_a_panorama_that_repeats_itself_has_no_heading(places):
    """Between two equal rows of trees; with a house at one end there is one again."""
    trees = np.tile(panoramas(PLACES)[:, :, : WIDTH // 2], 2)
    house = trees.copy()
    house[:, 4:, 10:16] = 255
    xy = places[1]
    built = fitted(ENCODER.encode(trees), xy, np.zeros(PLACES))
    found = built.bearings(ENCODER.encode(np.roll(trees, 9, axis=2)), xy)
    assert np.isnan(found.heading).all()
    np.testing.assert_allclose(found.rival, found.peak, rtol=1e-4)
    assert (found.peak > 0.97).all()
    built = fitted(ENCODER.encode(house), xy, np.zeros(PLACES))
    found = built.bearings(ENCODER.encode(np.roll(house, 9, axis=2)), xy)
    clear = found.peak > CLEAR * found.rival
    np.testing.assert_array_equal(np.isfinite(found.heading), clear)
    assert off_deg(found.heading[clear], 2 * np.pi * 9 / WIDTH).max() < 0.1
    assert clear.mean() > 0.5


def test_noise_is_like_no_place_and_blackness_has_no_heading(compass, places):
    noise = np.random.default_rng(5).integers(0, 256, (PLACES, HEIGHT, WIDTH), dtype=np.uint8)
    found = compass.bearings(ENCODER.encode(noise), places[1])
    assert found.peak.max() < 0.2
    nothing = compass.bearings(np.zeros((1, ENCODER.dim), np.float32), places[1][:1])
    assert (nothing.peak.item(), np.isnan(nothing.heading.item())) == (0, True)


def test_several_frames_of_a_place_become_one(places):
    """Whatever their headings; where they were, in the mean."""
    signatures, xy = places
    turns = np.random.default_rng(2).uniform(-3, 3, (5, PLACES))
    nearby = np.random.default_rng(3).uniform(-0.2, 0.2, (5, PLACES, 2))
    frames = np.concatenate([ENCODER.turned(signatures, turn) for turn in turns])
    built = fitted(frames, (xy + nearby).reshape(-1, 2), turns.ravel())
    assert len(built.codes) == PLACES
    order = [np.linalg.norm(built.xy - one, axis=1).argmin() for one in xy]
    np.testing.assert_allclose(built.xy[order], xy + nearby.mean(axis=0), atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(built.codes.rows(), axis=1), 1, atol=0.02)
    assert ((built.codes.rows()[order] * signatures).sum(axis=1) > 0.99).all()


def test_frames_without_a_heading_do_not_count(places, compass):
    signatures, xy = places
    heading = np.linspace(-3, 9, PLACES)
    frames = np.concatenate([ENCODER.turned(signatures, heading), ENCODER.encode(panoramas(PLACES, seed=9))])
    around = np.concatenate([xy, xy + 0.1])
    built = fitted(frames, around, np.concatenate([heading, np.full(PLACES, np.nan)]))
    for name, array in built.to_arrays().items():
        np.testing.assert_array_equal(array, compass.to_arrays()[name])


def test_without_headings_or_phases_there_is_no_compass(places):
    signatures, xy = places
    assert Compass.fit(ENCODER, Codes.of(signatures), xy, np.full(PLACES, np.nan), CELL_M) is None
    blind = Codes.of(np.empty((PLACES, 0), np.float32))
    assert Compass.fit(ENCODER, blind, xy, np.zeros(PLACES), CELL_M) is None


@pytest.mark.parametrize("count", [1, 2, BLENDED, BLENDED + 1])
def test_few_places(places, count):
    signatures, xy = (array[:count] for array in places)
    built = fitted(signatures, xy, np.zeros(count))
    found = built.bearings(ENCODER.turned(signatures, np.full(count, 0.7)), xy)
    assert off_deg(found.heading, 0.7).max() < 0.1
    persuasion = built.persuasion(signatures, np.tile(xy, (count, 1, 1)))
    np.testing.assert_array_equal(persuasion.argmax(axis=1), np.arange(count))


def test_far_from_all_places_the_nearest_one_is_asked(places, compass):
    signatures, xy = places
    corner = np.flatnonzero((xy == 0).all(axis=1)).item()
    image = signatures[corner : corner + 1]
    near, far = (compass.bearings(image, np.array([[-at, -at]])) for at in (0.0, 500.0))
    assert far.peak.item() == pytest.approx(near.peak.item(), abs=1e-4)
    assert far.heading.item() == pytest.approx(near.heading.item(), abs=1e-4)


def test_between_places_they_are_blended(places):
    """By how near they are: exp(-2 (d^2 - d_nearest^2) / cell^2), of the nearest four."""
    signatures, xy = places[0], places[1] / 4  # 0.5 m apart
    built = fitted(signatures, xy, np.zeros(PLACES))
    spots = np.random.default_rng(4).uniform(0.3, 1.7, (20, 2))
    stored = built.codes.rows()
    images, expected = [], []
    for spot in spots:
        distance = np.linalg.norm(built.xy - spot, axis=1)
        nearest = np.argsort(distance)[:BLENDED]
        weight = np.exp(-2 * (distance[nearest] ** 2 - distance.min() ** 2) / CELL_M**2)
        blend = (weight[:, None] * stored[nearest]).sum(axis=0)
        images.append(signatures[nearest[:2]].sum(axis=0) / np.linalg.norm(signatures[nearest[:2]].sum(axis=0)))
        expected.append(curve_by_rolling(images[-1], blend / np.linalg.norm(blend)).max())
    found = built.bearings(np.array(images, np.float32), spots)
    np.testing.assert_allclose(found.peak, expected, atol=1e-5)
    # A blend is more like what is between than either of the two.
    middle = (built.xy[:1] + built.xy[1:2]) / 2
    image = (stored[0] + stored[1])[None] / np.linalg.norm(stored[0] + stored[1])
    at_it, beside = built.bearings(image, middle), built.bearings(image, built.xy[:1])
    assert at_it.peak.item() > beside.peak.item() + 0.02


def test_persuasion_is_for_the_right_place_whatever_the_heading(places, compass):
    signatures, xy = places
    rng = np.random.default_rng(6)
    images = ENCODER.turned(signatures, rng.uniform(-3, 3, PLACES))
    candidates = np.stack([rng.permutation(PLACES)[:8] for _ in range(PLACES)])
    right = rng.integers(0, 8, PLACES)
    candidates[np.arange(PLACES), right] = np.arange(PLACES)
    persuasion = compass.persuasion(images, xy[candidates] + rng.uniform(-0.1, 0.1, (PLACES, 8, 2)))
    assert persuasion.shape == (PLACES, 8)
    assert ((persuasion > 0) & (persuasion <= 1)).all()
    best = candidates == np.arange(PLACES)[:, None]
    np.testing.assert_array_equal(persuasion[best], 1)
    assert persuasion[~best].max() < 0.01


def test_persuasion_grows_with_the_peak(places, compass):
    """By a factor of e for every thirtieth."""
    signatures, xy = places
    stored = compass.codes.rows()
    images = (signatures[:5] + 0.8 * signatures[5:10]) / np.linalg.norm(
        signatures[:5] + 0.8 * signatures[5:10], axis=1, keepdims=True
    )
    found = compass.persuasion(images, np.stack([xy[:5], xy[5:10], xy[10:15]], axis=1))
    for row in range(5):
        place = [np.linalg.norm(compass.xy - xy[row + step], axis=1).argmin() for step in (0, 5, 10)]
        peaks = np.array([curve_by_rolling(images[row], stored[one]).max() for one in place])
        np.testing.assert_allclose(np.log(found[row]), 30 * (peaks - peaks.max()), atol=1e-3)


def test_an_image_alone_is_told_what_it_is_told_among_others(places, compass):
    signatures, xy = places
    together = compass.bearings(signatures, xy + 0.3)
    for row in (0, 13, 29):
        alone = compass.bearings(signatures[row : row + 1], xy[row : row + 1] + 0.3)
        assert alone.heading.item() == together.heading[row]
        assert alone.peak.item() == together.peak[row]


def test_arrays_hold_everything(places, compass):
    signatures, xy = places
    again = Compass.from_arrays(ENCODER, compass.to_arrays())
    assert again.cell_m == compass.cell_m
    found, expected = (one.bearings(signatures, xy + 0.2) for one in (again, compass))
    for name in ("heading", "peak", "rival"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
    assert compass.to_arrays()["codes"].dtype == np.int8


def test_arrays_that_are_missing_or_too_many(compass):
    for missing in compass.to_arrays():
        arrays = {key: array for key, array in compass.to_arrays().items() if key != missing}
        with pytest.raises(ArrayError, match=f"lacks the stored arrays {missing}"):
            Compass.from_arrays(ENCODER, arrays)
    with pytest.raises(ArrayError, match=r"one size of its places, got an array of shape \(2,\)"):
        Compass.from_arrays(ENCODER, compass.to_arrays() | {"cell": np.ones(2)})
