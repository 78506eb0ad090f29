import pytest

from andante.evaluation.experiments import tracking
from andante.evaluation.experiments.followers import FOLLOWERS
from andante.evaluation.experiments.tracking import mapped_sizes, run_tracking
from andante.evaluation.experiments.trials import Bench


def test_how_many_are_mapped():
    assert [mapped_sizes(count) for count in (2, 3, 4, 6, 10)] == [[1], [1, 2], [1, 3], [1, 3, 5], [1, 3, 9]]


def test_every_follower_on_every_split(cache, years, tiny, monkeypatch):
    outcome = run_tracking(Bench(years, cache), 5, tiny)
    tracks = outcome.figures["tracks"]
    assert [one["mapped"] for one in tracks] == [1, 1, 2, 2]
    assert all(list(one["localizers"]) == list(FOLLOWERS) for one in tracks)
    assert all(told["n"] == 70 for one in tracks for told in one["localizers"].values())
    for size, by_name in outcome.figures["by_sessions"].items():
        here = [one["localizers"] for one in tracks if one["mapped"] == int(size)]
        for name, figures in by_name.items():
            assert figures["mean_m"] == pytest.approx(sum(one[name]["mean_m"] for one in here) / len(here))
            assert figures["max_m"] == max(one[name]["max_m"] for one in here)
    assert [len(table.rows) for table in outcome.tables[:3]] == [4, 4, 8]

    # A second run learns nothing.
    monkeypatch.setattr(tracking, "learned", lambda *_: pytest.fail("learnt again"))
    assert run_tracking(Bench(years, cache), 5, tiny).figures == outcome.figures
