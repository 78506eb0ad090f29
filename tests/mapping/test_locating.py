"""Readout and compass together: which place it is, how much like it an image is, and how strange it is elsewhere."""

import numpy as np
import pytest

from andante.features import PhaseEncoder
from andante.mapping.codes import Codes
from andante.mapping.compass import Bearings, Compass
from andante.mapping.config import ReadoutConfig
from andante.mapping.located import Hidden, tempered
from andante.mapping.locating import Locator, Sighting, doubt_of
from andante.mapping.readout import LocalReadout
from andante.mapping.regressions import PolynomialReadout

N, TWINS_APART_M = 80, 50.0
ENCODER = PhaseEncoder(12, 120)
FIELDS = ("xy", "covariance", "likeness", "agreement", "candidates", "weights", "spread")


def signatures(seed: int, count: int = N) -> np.ndarray:
    """(count, p) of places whose neighbours look alike."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(count, ENCODER.dim))
    along = np.linspace(-1, 1, 9)
    smooth = np.stack([np.convolve(column, np.exp(-4 * along**2), "same") for column in steps.T], axis=1)
    return (smooth / np.linalg.norm(smooth, axis=1, keepdims=True)).astype(np.float32)


class Street:
    """Two rows of places whose slow features are nearly the same, and whose phases are not."""

    def __init__(self) -> None:
        along = np.linspace(0, 12, N)
        slow = np.sin(along[:, None] * (0.25 + 0.15 * np.arange(6)) + np.arange(6)) * np.sqrt(2)
        self.slow = np.concatenate([slow, slow + 1e-4])
        self.xy = np.concatenate([np.column_stack([along, at + 0 * along]) for at in (0.0, TWINS_APART_M)])
        self.phase = np.concatenate([signatures(0), signatures(1)])
        self.spread = np.full(2 * N, 0.5)
        self.readout = LocalReadout.fit(self.slow, self.xy, np.ones(6), ReadoutConfig(), 1.0, spread=self.spread)
        self.compass = Compass.fit(ENCODER, Codes.of(self.phase), self.xy, np.zeros(2 * N), 0.5)

    def seen(self, heading: float = 0.0, away: float = 0.05) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Slow features, spread and phases of images at all places."""
        turned = ENCODER.turned(self.phase, np.full(2 * N, heading))
        return self.slow + away, self.spread, turned


@pytest.fixture(scope="module")
def street() -> Street:
    return Street()


def test_without_a_compass_it_is_the_readout(street):
    slow, spread, phase = street.seen()
    sighting = Locator(street.readout, None).sight(slow, 2 * spread, phase)
    located = street.readout.locate(slow)
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(sighting.located, name), getattr(located, name))
    np.testing.assert_array_equal(sighting.likeness, tempered(located.likeness, 2 * spread, located.spread))
    np.testing.assert_array_equal(sighting.sigma, located.sigma)
    np.testing.assert_array_equal(sighting.doubt, 1)
    assert sighting.bearings is None


def test_phases_tell_places_apart_that_slow_features_do_not(street):
    slow, spread, phase = street.seen(heading=1.3)
    right = street.xy[:, 1] > TWINS_APART_M / 2
    alone = street.readout.locate(slow).xy[:, 1] > TWINS_APART_M / 2
    assert (alone == right).mean() < 0.7
    sighting = Locator(street.readout, street.compass).sight(slow, spread, phase)
    np.testing.assert_array_equal(sighting.located.xy[:, 1] > TWINS_APART_M / 2, right)
    assert sighting.located.agreement.min() > 0.9
    off = np.mod(sighting.bearings.heading - 1.3 + np.pi, 2 * np.pi) - np.pi
    assert np.abs(np.degrees(off)).max() < 1


def test_likeness_is_that_of_both_and_doubt_grows_where_the_phases_differ(street):
    slow, spread, phase = street.seen()
    foreign = np.random.default_rng(2).normal(size=phase.shape).astype(np.float32)
    blend = phase + 0.05 * foreign
    blend /= np.linalg.norm(blend, axis=1, keepdims=True)
    locator = Locator(street.readout, street.compass)
    for seen in (phase, blend):
        sighting = locator.sight(slow, spread, seen)
        located, bearings = sighting.located, sighting.bearings
        own = tempered(located.likeness, spread, located.spread)
        np.testing.assert_allclose(sighting.likeness, own * bearings.peak)
        np.testing.assert_allclose(sighting.sigma, located.sigma * sighting.doubt)
        np.testing.assert_allclose(sighting.doubt, np.exp(1.4 * (1 - bearings.peak)))
        at_it = street.compass.bearings(seen, located.xy)
        np.testing.assert_array_equal(bearings.peak, at_it.peak)
        np.testing.assert_array_equal(bearings.heading, at_it.heading)
    assert (locator.sight(slow, spread, blend).doubt > 1.1 * locator.sight(slow, spread, phase).doubt).all()


def test_doubt_is_between_one_and_its_largest():
    peak = np.array([-0.1, 0.0, 0.5, 1.0, 1.0 + 1e-6])
    doubt = doubt_of(Bearings(peak, peak, peak), 5)
    assert (np.diff(doubt) <= 0).all()
    assert (doubt[0], doubt[-1]) == (np.exp(1.4), 1.0)
    np.testing.assert_array_equal(doubt_of(None, 3), 1)


@pytest.mark.parametrize("with_compass", [True, False])
def test_strangers_are_images_whose_own_place_is_hidden(street, with_compass):
    slow, spread, phase = street.seen(away=0.0)
    locator = Locator(street.readout, street.compass if with_compass else None)
    hidden = Hidden(street.xy, 2.0)
    strange = locator.strangers(slow, spread, phase, hidden)
    assert strange.shape == (2 * N,)
    if not with_compass:  # the twin is as like them as they are themselves
        assert np.median(strange) > 0.9
        return
    assert (strange < 0.7 * locator.sight(slow, spread, phase).likeness).all()
    found = locator.sight(slow, spread, phase, hidden)
    np.testing.assert_array_equal(strange, found.likeness)
    assert (np.linalg.norm(found.located.xy - street.xy, axis=1) > 1.0).all()


def test_who_has_nothing_left_is_no_stranger_and_located_nowhere(street):
    slow, spread, phase = street.seen()
    around = np.where(np.arange(2 * N)[:, None] < 30, street.xy, 1e6)
    locator, hidden = Locator(street.readout, street.compass), Hidden(around, 1000.0)
    assert len(locator.strangers(slow, spread, phase, hidden)) == 2 * N - 30
    sighting = locator.sight(slow, spread, phase, hidden)
    assert np.isnan(sighting.located.xy[:30]).all()
    np.testing.assert_array_equal(sighting.likeness[:30], 0)
    assert np.isfinite(sighting.sigma).all()


def test_a_regression_knows_no_strangers_but_headings(street):
    slow, spread, phase = (part[:N] for part in street.seen(heading=-2.0, away=0.0))
    readout = PolynomialReadout.fit(slow, street.xy[:N], ReadoutConfig(kind="polynomial", inputs=4))
    locator = Locator(readout, street.compass)
    assert len(locator.strangers(slow, spread, phase, Hidden(street.xy[:N], 1.0))) == 0
    sighting = locator.sight(slow, spread, phase)
    np.testing.assert_array_equal(sighting.located.xy, readout.locate(slow).xy)
    off = np.mod(sighting.bearings.heading + 2.0 + np.pi, 2 * np.pi) - np.pi
    assert np.degrees(np.nanmedian(np.abs(off))) < 1


def test_an_image_alone_is_sighted_as_among_others(street):
    locator = Locator(street.readout, street.compass)
    seen = tuple(np.tile(part, (4,) + (1,) * (part.ndim - 1)) for part in street.seen(heading=0.4))
    together: Sighting = locator.sight(*seen)
    for row in (0, 255, 256, 600):
        alone = locator.sight(*(part[row : row + 1] for part in seen))
        np.testing.assert_allclose(alone.located.xy[0], together.located.xy[row], atol=1e-4)
        assert alone.likeness.item() == pytest.approx(together.likeness[row], abs=1e-5)
        assert alone.bearings.heading.item() == pytest.approx(together.bearings.heading[row], abs=1e-4)
