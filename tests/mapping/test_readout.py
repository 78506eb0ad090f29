"""From slow features to positions: three ways, each against its own definition."""

import dataclasses
from itertools import combinations_with_replacement

import numpy as np
import pytest

from andante.errors import ArrayError, LearningError
from andante.mapping.config import ReadoutConfig
from andante.mapping.located import Hidden
from andante.mapping.readout import LocalReadout
from andante.mapping.regressions import GaussianProcessReadout, PolynomialReadout

CONFIG = ReadoutConfig()
CONSENSUS_M = 1.0


@pytest.fixture(scope="module")
def path() -> tuple[np.ndarray, np.ndarray]:
    """Slow features (120, 6) and positions (120, 2) of frames along a path on which every place looks different."""
    rng = np.random.default_rng(1)
    along = np.linspace(0, 12, 120)
    xy = np.column_stack([along, np.sin(along / 2)])
    phases = rng.uniform(0, 6, 6)
    slow = np.sin(along[:, None] * (0.25 + 0.15 * np.arange(6)) + phases) * np.sqrt(2)
    return slow - slow.mean(axis=0), xy


@pytest.fixture(scope="module")
def local(path) -> LocalReadout:
    return LocalReadout.fit(*path, np.linspace(2, 1, 6), CONFIG, CONSENSUS_M, spread=np.linspace(0.3, 0.5, 120))


@pytest.fixture(scope="module")
def polynomial(path) -> PolynomialReadout:
    return PolynomialReadout.fit(*path, ReadoutConfig(kind="polynomial", inputs=4))


@pytest.fixture(scope="module")
def process(path) -> GaussianProcessReadout:
    return GaussianProcessReadout.fit(*path, np.ones(6))


READOUTS = ["local", "polynomial", "process"]


@pytest.mark.parametrize("name", READOUTS)
def test_arrays_hold_everything(name, path, request):
    readout = request.getfixturevalue(name)
    again = type(readout).from_arrays(readout.to_arrays())
    located, relocated = readout.locate(path[0][::7] + 0.05), again.locate(path[0][::7] + 0.05)
    for field in ("xy", "covariance", "likeness", "agreement", "candidates", "weights", "spread"):
        np.testing.assert_array_equal(getattr(located, field), getattr(relocated, field))


@pytest.mark.parametrize("name", READOUTS)
def test_a_missing_array_and_wrong_numbers_are_named(name, request):
    readout = request.getfixturevalue(name)
    for missing in readout.to_arrays():
        arrays = {key: array for key, array in readout.to_arrays().items() if key != missing}
        with pytest.raises(ArrayError, match=f"lacks the stored arrays {missing}"):
            type(readout).from_arrays(arrays)
    with pytest.raises(ArrayError, match=r"numbers, got an array of shape \(7,\)"):
        type(readout).from_arrays(readout.to_arrays() | {"numbers": np.ones(7)})


@pytest.mark.parametrize("name", READOUTS)
def test_shapes_and_ranges(name, path, request):
    slow = np.random.default_rng(3).normal(size=(50, 6))
    located = request.getfixturevalue(name).locate(slow)
    assert located.xy.shape == (50, 2)
    assert (located.sigma > 0).all()
    for share in (located.likeness, located.agreement):
        assert ((share >= 0) & (share <= 1 + 1e-12)).all()
    np.testing.assert_allclose(located.agreement + located.weights.sum(axis=1), 1)
    assert np.linalg.eigvalsh(located.covariance).min() > 0


def test_local_finds_its_references(local, path):
    """Those it keeps exactly; as they were before they were rounded, within a tenth of their distance."""
    slow, xy = path
    np.testing.assert_allclose(local.locate(local.references / local.metric).xy, xy, atol=1e-4)
    located = local.locate(slow)
    np.testing.assert_allclose(located.xy, xy, atol=0.01)
    np.testing.assert_allclose(located.likeness, 1, atol=1e-4)
    np.testing.assert_allclose(located.agreement, 1, atol=1e-6)


def local_by_loops(references, xy, query, neighbours, sharpness, consensus):
    """One query: votes of the nearest, the reference with most of them around it, their mean."""
    squared = [sum((a - b) ** 2 for a, b in zip(query, reference, strict=True)) for reference in references]
    nearest = sorted(range(len(xy)), key=squared.__getitem__)[:neighbours]
    votes = [np.exp(-sharpness * (squared[i] / squared[nearest[0]] - 1)) for i in nearest]
    votes = [vote / sum(votes) for vote in votes]
    near = [[np.hypot(*(xy[i] - xy[j])) <= consensus for j in nearest] for i in nearest]
    support = [sum(vote for vote, together in zip(votes, row, strict=True) if together) for row in near]
    winner = int(np.argmax(support))
    inside = [vote if together else 0 for vote, together in zip(votes, near[winner], strict=True)]
    position = sum(vote * xy[i] for vote, i in zip(inside, nearest, strict=True)) / sum(inside)
    return position, sum(inside), 1 - squared[nearest[0]] / np.median(squared)


def test_local_is_a_vote_of_the_nearest_references(local, path):
    slow, xy = path
    config = ReadoutConfig(neighbours=8, sharpness=4.0)
    local = LocalReadout.fit(slow, xy, local.metric, config, CONSENSUS_M)
    queries = np.random.default_rng(4).normal(size=(40, 6))
    located = local.locate(queries)
    references = local.references.astype(np.float64)
    for row, query in enumerate(queries):
        position, agreement, likeness = local_by_loops(references, xy, query * local.metric, 8, 4.0, CONSENSUS_M)
        np.testing.assert_allclose(located.xy[row], position, atol=1e-3)
        assert located.agreement[row] == pytest.approx(agreement, abs=1e-3)
        assert located.likeness[row] == pytest.approx(max(0, likeness), abs=1e-4)


@pytest.mark.parametrize(("unlike", "away"), [(0.0, 0.05), (1e-3, 0.15)])
def test_two_places_that_look_alike_give_low_agreement_and_a_large_sigma(path, unlike, away):
    """Two twins that are not quite the same may be told apart from nearby, by how they are coded."""
    slow, xy = path
    twice = np.concatenate([slow, slow + unlike]), np.concatenate([xy, xy + np.array([100, 0])])
    readout = LocalReadout.fit(*twice, np.ones(6), CONFIG, CONSENSUS_M)
    clear, unclear = LocalReadout.fit(slow, xy, np.ones(6), CONFIG, CONSENSUS_M), readout
    query = slow[30:90:5] + away
    assert clear.locate(query).agreement.min() > 0.9
    located = unclear.locate(query)
    assert located.agreement.max() < 0.8
    assert located.sigma.min() > 40 > 20 * clear.locate(query).sigma.max()
    # The other place stays a candidate.
    others = (located.candidates * (located.weights > 0.1)[:, :, None]).max(axis=1)[:, 0]
    positions = np.maximum(located.xy[:, 0], others)
    assert (positions > 99).all()


def test_likeness_without_its_own_place_is_that_to_what_an_image_resembles_elsewhere(local, path):
    slow, xy = path
    apart = 2.0
    strange = local.locate(slow, hidden=Hidden(xy, apart)).likeness
    assert strange.shape == (120,)
    assert ((strange >= 0) & (strange <= 1)).all()
    assert (strange < local.locate(slow).likeness - 0.01).all()
    squared = (((slow * local.metric)[:, None] - local.references[None]) ** 2).sum(axis=2)
    elsewhere = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1)) > apart
    expected = 1 - np.where(elsewhere, squared, np.inf).min(axis=1) / np.median(squared, axis=1)
    np.testing.assert_allclose(strange, np.clip(expected, 0, 1), atol=1e-4)


def without(local: LocalReadout, gone: np.ndarray) -> LocalReadout:
    """The same readout, some of its references thrown away."""
    kept = np.flatnonzero(~gone)
    return dataclasses.replace(
        local,
        codes=local.codes.subset(kept),
        xy=local.xy[kept],
        spread=local.spread[kept],
        neighbours=min(local.neighbours, len(kept)),
    )


@pytest.mark.parametrize("left", [1, 2, 5, 40])
def test_hidden_references_do_nothing(local, path, left):
    """As if they were not there, also where fewer are left than vote; only likeness is measured against all of them."""
    slow, xy = path
    for row in (3, 60, 117):
        away = np.linalg.norm(local.xy - xy[row], axis=1)
        hidden = Hidden(xy[row : row + 1], float(np.sort(away)[-left - 1]))
        rest = without(local, away <= hidden.radius)
        assert len(rest.xy) == left
        # Somewhere between the image and what is hidden, so that what is hidden would have a say.
        query = slow[row : row + 1] + 0.1
        found, expected = local.locate(query, hidden=hidden), rest.locate(query)
        for name in ("xy", "covariance", "agreement"):
            np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-6, err_msg=name)
        weighty = found.weights[0] > 0
        assert (np.linalg.norm(found.candidates[0][weighty] - xy[row], axis=1) > hidden.radius).all()
        assert found.weights.sum() == pytest.approx(expected.weights.sum())


def test_an_image_whose_references_are_all_hidden_is_nowhere(local, path):
    slow, xy = path
    around = np.where(np.arange(120)[:, None] < 60, xy, 1e6)
    located = local.locate(slow, hidden=Hidden(around, 1000.0))
    np.testing.assert_array_equal(np.isnan(located.xy).all(axis=1), np.arange(120) < 60)
    np.testing.assert_array_equal(located.likeness[:60], 0)
    np.testing.assert_array_equal(located.xy[60:], local.locate(slow[60:]).xy)


def test_blocks_of_images_hide_what_each_of_them_hides(local, path):
    slow, xy = (np.tile(array, (3, 1)) for array in path)
    many = local.locate(slow, hidden=Hidden(xy, 2.0))
    for row in (0, 255, 256, 359):
        alone = local.locate(slow[row : row + 1], hidden=Hidden(xy[row : row + 1], 2.0))
        np.testing.assert_allclose(many.xy[row], alone.xy[0], atol=1e-5)
        assert many.likeness[row] == pytest.approx(alone.likeness[0], abs=1e-5)


def test_a_witness_decides_between_places_that_look_alike(path):
    slow, xy = path
    twice = np.concatenate([slow, slow + 1e-3]), np.concatenate([xy, xy + np.array([100, 0])])
    readout = LocalReadout.fit(*twice, np.ones(6), CONFIG, CONSENSUS_M)
    query, asked = np.tile(slow[30:90:5] + 0.1, (30, 1)), []

    def for_the_twin(rows: slice, positions: np.ndarray) -> np.ndarray:
        asked.append((rows, positions.shape))
        return np.where(positions[..., 0] > 50, 1.0, 1e-6)

    located = readout.locate(query, for_the_twin)
    assert (located.xy[:, 0] > 99).all()
    assert located.agreement.min() > 0.99
    assert asked == [(slice(0, 256), (256, 12, 2)), (slice(256, 512), (104, 12, 2))]
    against = readout.locate(query, lambda rows, positions: np.where(positions[..., 0] > 50, 1e-6, 1.0))
    assert (against.xy[:, 0] < 50).all()


def test_an_indifferent_witness_changes_nothing(local, path):
    plain = local.locate(path[0] + 0.1)
    asked = local.locate(path[0] + 0.1, lambda rows, positions: np.full(positions.shape[:2], 0.3))
    for name in ("xy", "covariance", "agreement", "likeness", "weights"):
        np.testing.assert_allclose(getattr(plain, name), getattr(asked, name), atol=1e-12)


@pytest.mark.parametrize("name", ["polynomial", "process"])
def test_regressions_have_no_references_to_weigh_or_hide(name, path, request):
    slow, xy = path
    readout = request.getfixturevalue(name)

    def witness(rows: slice, positions: np.ndarray) -> np.ndarray:
        raise AssertionError("a regression has no candidates")

    np.testing.assert_array_equal(readout.locate(slow, witness, Hidden(xy, 5.0)).xy, readout.locate(slow).xy)


def test_spread_is_that_of_the_references_that_an_image_resembles(local, path):
    np.testing.assert_allclose(local.locate(path[0]).spread, np.linspace(0.3, 0.5, 120), atol=0.01)
    assert np.isinf(LocalReadout.fit(*path, np.ones(6), CONFIG, CONSENSUS_M).locate(path[0]).spread).all()


def test_fewer_references_than_neighbours(path):
    slow, xy = (array[:3] for array in path)
    readout = LocalReadout.fit(slow, xy, np.ones(6), CONFIG, CONSENSUS_M)
    assert readout.neighbours == 3
    np.testing.assert_allclose(readout.locate(readout.references).xy, xy, atol=1e-4)


def test_between_references_an_image_is_placed_between_them(local, path):
    slow, xy = path
    middle = (slow[:-1] + slow[1:]) / 2
    truth = (xy[:-1] + xy[1:]) / 2
    apart = np.linalg.norm(local.locate(middle).xy - truth, axis=1)
    assert np.median(apart) < 0.02
    voted = LocalReadout.fit(slow, xy, local.metric, CONFIG.model_copy(update={"caution": 1e9}), CONSENSUS_M)
    assert np.median(np.linalg.norm(voted.locate(middle).xy - truth, axis=1)) > np.median(apart)


def test_what_looks_unfamiliar_is_not_interpolated(path):
    """Moved far away from all references, the votes decide alone, whatever lies in the direction of the move."""
    slow, xy = path
    wide = np.column_stack([slow, np.zeros(len(slow))])
    readout = LocalReadout.fit(wide, xy, np.ones(7), CONFIG, CONSENSUS_M)
    voted = LocalReadout.fit(wide, xy, np.ones(7), CONFIG.model_copy(update={"caution": 1e9}), CONSENSUS_M)
    moved = np.column_stack([slow, np.full(len(slow), 3.0)])
    np.testing.assert_allclose(readout.locate(moved).xy, voted.locate(moved).xy, atol=0.02)


def interpolated_by_constraint(references, votes, query, caution, typical):
    """The weights as the solution of their own optimality conditions, one image at a time."""
    offset = references - query
    gram = offset @ offset.T
    m = len(references)
    squared = ((references[:, None] - references[None]) ** 2).sum(axis=2)
    gap = max(squared.sum() / (m * (m - 1)), 1e-9 * typical)
    pull = max(caution * np.diag(gram).min() ** 2 / gap, 1e-3 * gap)
    system = np.block([[gram + pull * np.eye(m), np.ones((m, 1))], [np.ones((1, m)), np.zeros((1, 1))]])
    return np.linalg.solve(system, np.append(pull * votes, 1))[:m]


def test_interpolation_solves_its_constrained_problem(path):
    slow, xy = path
    config = ReadoutConfig(neighbours=5, sharpness=0.5, caution=2.0)
    readout = LocalReadout.fit(slow, xy, np.ones(6), config, 1000.0)  # all belong together
    references = readout.references.astype(np.float64)
    queries = slow[::7] + 0.1 * np.random.default_rng(6).normal(size=slow[::7].shape)
    for query, found in zip(queries, readout.locate(queries).xy, strict=True):
        squared = ((references - query) ** 2).sum(axis=1)
        nearest = np.argsort(squared)[:5]
        votes = np.exp(-0.5 * (squared[nearest] / squared[nearest[0]] - 1))
        weights = interpolated_by_constraint(references[nearest], votes / votes.sum(), query, 2.0, readout.typical)
        np.testing.assert_allclose(found, weights @ xy[nearest], atol=2e-3)


def test_references_are_kept_in_one_byte_a_number(local, path):
    """Far closer to what they were than to the next one."""
    references = path[0] * local.metric
    off = np.linalg.norm(local.references - references, axis=1)
    assert off.max() < 0.25 * np.median(np.linalg.norm(np.diff(references, axis=0), axis=1))
    arrays = local.to_arrays()
    assert (arrays["codes"].dtype, arrays["spread"].dtype, local.spread.dtype) == (np.int8, np.float32, np.float32)
    np.testing.assert_array_equal(local.codes.rows(), local.references)


def test_a_polynomial_is_least_squares_on_all_products(polynomial, path):
    slow, xy = path
    terms = [[1.0, *x[:4], *(x[i] * x[j] for i, j in combinations_with_replacement(range(4), 2))] for x in slow]
    solution, *_ = np.linalg.lstsq(np.array(terms), xy, rcond=None)
    fitted = np.array(terms) @ solution
    np.testing.assert_allclose(polynomial.locate(slow).xy, fitted, atol=1e-8)
    assert polynomial.terms == 15
    residual = (xy - fitted).T @ (xy - fitted) / (120 - 15)
    np.testing.assert_allclose(polynomial.residual, residual, rtol=1e-8)


def test_a_polynomial_recovers_a_polynomial():
    rng = np.random.default_rng(5)
    slow = rng.normal(size=(200, 3))
    truth = np.column_stack([1 + slow[:, 0] - 2 * slow[:, 1] * slow[:, 2], slow[:, 0] ** 2])
    noisy = truth + rng.normal(0, 1e-3, truth.shape)
    readout = PolynomialReadout.fit(slow, noisy, ReadoutConfig(inputs=3))
    np.testing.assert_allclose(readout.locate(slow).xy, truth, atol=2e-3)


def test_a_polynomial_trusts_itself_less_far_from_what_it_has_seen(polynomial, path):
    near, far = polynomial.locate(path[0][:1]), polynomial.locate(10 * path[0][:1])
    assert far.likeness[0] < 0.1
    assert far.sigma[0] > 3 * near.sigma[0]


@pytest.mark.parametrize(("inputs", "degree", "terms"), [(6, 4, 210), (192, 4, 59_626_385)])
def test_more_terms_than_frames_are_refused_before_they_are_made(path, inputs, degree, terms):
    slow = np.random.default_rng(0).normal(size=(120, inputs))
    message = rf"a polynomial of degree {degree} in {inputs} slow features has {terms} terms, but there are 120 frames"
    with pytest.raises(LearningError, match=message):
        PolynomialReadout.fit(slow, path[1], ReadoutConfig(inputs=inputs, degree=degree))


def test_a_gaussian_process_interpolates_and_knows_where_it_does_not(process, path):
    slow, xy = path
    at_data = process.locate(slow)
    assert np.linalg.norm(at_data.xy - xy, axis=1).max() < 0.2
    direction = np.full((1, 6), 1.0)
    away = [process.locate(slow[60:61] + step * direction) for step in (0, 0.5, 1, 2, 4, 50)]
    sigmas = [located.sigma[0] for located in away]
    assert sigmas == sorted(sigmas)
    assert sigmas[-1] == pytest.approx(np.sqrt(2 * process.prior * (1 + process.noise)), rel=1e-6)
    assert away[-1].likeness[0] == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(away[-1].xy[0], process.mean, atol=1e-6)


def test_a_gaussian_process_is_the_textbook_formula(process, path):
    query = path[0][5:6] + 0.3
    kernel = np.exp(-((process.points[:, None] - process.points[None]) ** 2).sum(axis=2) / (2 * process.length**2))
    cross = np.exp(-((query - process.points) ** 2).sum(axis=1) / (2 * process.length**2))
    noisy = kernel + (process.noise + 1e-9) * np.eye(len(kernel))
    mean = process.mean + cross @ np.linalg.solve(noisy, path[1] - process.mean)
    variance = process.prior * (1 - cross @ np.linalg.solve(noisy, cross) + process.noise)
    located = process.locate(query)
    np.testing.assert_allclose(located.xy[0], mean, rtol=1e-5)
    np.testing.assert_allclose(located.covariance[0], variance * np.eye(2), rtol=1e-4)


def test_images_that_all_look_the_same_are_refused(path):
    alike = np.ones_like(path[0])
    with pytest.raises(LearningError, match="all references look the same in slow-feature space"):
        LocalReadout.fit(alike, path[1], np.ones(6), CONFIG, CONSENSUS_M)
    with pytest.raises(LearningError, match="needs frames at different places that look different"):
        GaussianProcessReadout.fit(alike, path[1], np.ones(6))
