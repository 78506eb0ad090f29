import statistics

import numpy as np
import pytest

from andante.evaluation.experiments.statistics import summary
from andante.evaluation.experiments.trials import Result


def result(rng, count, scale, seconds, size):
    truth = rng.uniform(-5, 5, (count, 2))
    return Result(truth + rng.normal(0, scale, (count, 2)), truth, seconds, size)


def test_against_a_slow_reference():
    rng = np.random.default_rng(4)
    results = [result(rng, 30 + 7 * n, 0.3 + 0.4 * n, 1.0 + n, 100 * n) for n in range(4)]
    errors = [
        [((x - u) ** 2 + (y - v) ** 2) ** 0.5 for (x, y), (u, v) in zip(one.xy, one.truth, strict=True)]
        for one in results
    ]
    means, pooled = [statistics.fmean(one) for one in errors], sorted(error for one in errors for error in one)
    found = summary(results)
    assert (found.trials, found.frames) == (4, len(pooled))
    assert found.mean_m == pytest.approx(statistics.fmean(means))
    assert found.variance_m2 == pytest.approx(statistics.variance(means))
    assert found.deviation_m == pytest.approx(statistics.stdev(means))
    assert found.median_m == pytest.approx(statistics.median(statistics.median(one) for one in errors))
    rank = 0.95 * (len(pooled) - 1)
    low = pooled[int(rank)]
    assert found.p95_m == pytest.approx(low + (rank - int(rank)) * (pooled[int(rank) + 1] - low))
    assert found.max_m == pytest.approx(pooled[-1])
    assert found.share_over_1m == pytest.approx(sum(error > 1 for error in pooled) / len(pooled))
    assert (found.seconds, found.bytes) == (2.5, 150.0)


def test_one_trial_has_no_variance():
    found = summary([result(np.random.default_rng(0), 5, 1.0, 0.5, 10)])
    assert found.variance_m2 is None
    assert found.deviation_m is None
    assert found.as_dict()["variance_m2"] is None
