import dataclasses

import numpy as np
import pytest

from andante.baselines import make_methods
from andante.errors import LearningError
from andante.evaluation.compare_tables import ERROR_COLUMNS
from andante.evaluation.experiments import comparison
from andante.evaluation.experiments.comparison import compared, run_comparison
from andante.evaluation.experiments.comparison_world import MAPPED, SEASONAL, SPATIAL, TEMPORAL, comparison_plan
from andante.evaluation.experiments.plans import Scale
from andante.evaluation.experiments.trials import Bench
from andante.simulator import make_garden

TINY = Scale(frames=80, image_px=96)
SEED = 5


@pytest.fixture(scope="module")
def pictured(embree, tmp_path_factory):
    return tmp_path_factory.mktemp("compared")


@pytest.fixture
def bench(pictured):
    return Bench(comparison_plan(SEED, TINY), pictured)


def lengths(scale):
    plan = comparison_plan(SEED, scale)
    garden = make_garden(plan.garden)
    return {session.name: session.truth(garden) for session in plan.sessions}


def test_as_many_images_as_the_thesis():
    driven = lengths(Scale(frames=1083, image_px=480))
    counts = {name: len(trajectory) for name, trajectory in driven.items()}
    assert counts == {MAPPED: 1083, TEMPORAL: 284, SPATIAL: 298, **dict.fromkeys(SEASONAL[:2], 284), SEASONAL[2]: 298}


def test_fewer_images_see_the_same_way():
    driven = lengths(TINY)
    assert {name: len(one) for name, one in driven.items()} == {
        MAPPED: 80, TEMPORAL: 21, SPATIAL: 22, SEASONAL[0]: 21, SEASONAL[1]: 21, SEASONAL[2]: 22,
    }  # fmt: skip
    whole = np.ptp(driven[MAPPED].xy_m, axis=0)
    assert (whole < (15, 9)).all()
    assert np.allclose(np.ptp(driven[TEMPORAL].xy_m, axis=0), whole, atol=0.3)


def test_everything_from_nothing_and_again(bench, monkeypatch):
    methods = make_methods(["andante", "nearest-5", "thumbnails"])
    monkeypatch.setattr(comparison, "default_methods", lambda options: (methods, ("posenet is left out: no torch",)))
    outcome = run_comparison(bench, SEED, TINY)
    temporal, spatial, *seasons, followed, seconds, costs = outcome.tables
    assert [row[0] for row in temporal.rows[:3]] == ["andante", "nearest-5", "thumbnails"]
    assert temporal.rows[3] == ("thesis 8.1: SFA", 0.48, 0.63, 0.78, 5.03, None, None, None, None, None)
    assert spatial.rows[-1][0] == "thesis 8.2: PoseNet"
    assert len(seasons) == 3
    assert all(len(row) == len(table.columns) for table in outcome.tables for row in table.rows)
    assert all(table.verdict for table in (temporal, spatial, *seasons, costs))
    assert [row[0] for row in followed.rows][:2] == [
        "border-later: andante + tracker",
        "border-later: andante, single images",
    ]
    row = dict(zip(seconds.columns, seconds.rows[-2], strict=True))
    assert (row["method"], row["times slow features"], row["times slow features "]) == (
        "thesis 8.3: 3D reconstruction (GPU), Active Search", "886", "34",
    )  # fmt: skip
    assert outcome.figures["methods"]["andante"]["tests"][SPATIAL]["n"] == 22
    assert any(note.startswith("goal across the lawn, single images") for note in outcome.notes)
    assert "posenet is left out: no torch" in outcome.notes
    assert "cut short" in outcome.notes[0]
    assert [plot.suffix for plot in outcome.plots] == ["", "temporal", "spatial", "spatial-autumn"]
    assert [one.name for one in outcome.contenders] == ["andante"]
    row = dict(zip(ERROR_COLUMNS, temporal.rows[1], strict=True))
    assert row["> 3 m [%]"] <= 50

    # A second run learns nothing.
    def never(*arguments, **options):
        pytest.fail("learnt again")

    monkeypatch.setattr(comparison, "enter", never)
    assert run_comparison(bench, SEED, TINY).figures == outcome.figures


def test_a_run_goes_on_after_the_last_finished_method(bench):
    @dataclasses.dataclass(frozen=True)
    class Breaking:
        name: str = "breaking"

        def learn(self, recordings, *, positions="reference", progress=None):
            raise KeyboardInterrupt

    (ridge,) = make_methods(["ridge"])
    with pytest.raises(KeyboardInterrupt):
        compared(bench, [ridge, Breaking()], quick=True)

    class Known:
        name = "ridge"

        def learn(self, *arguments, **options):
            pytest.fail("learnt again")

    found = compared(bench, [Known()], quick=True)
    assert found.entries[0].failure is None


def test_failures_are_tried_again(bench):
    class Failing:
        name = "failing"
        tries = 0

        def learn(self, *arguments, **options):
            self.tries += 1
            raise LearningError("not today")

    failing, others = Failing(), make_methods(["ridge"])
    for _ in range(2):
        found = compared(bench, [*others, failing], quick=True)
        assert found.entries[1].failure == "not today"
    assert failing.tries == 2
