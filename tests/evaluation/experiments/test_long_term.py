import numpy as np
import pytest

from andante.evaluation.experiments.contenders import NEAREST, Contender, Fitted
from andante.evaluation.experiments.long_term import THESIS_AT_NINE, permutations, run_long_term
from andante.evaluation.experiments.plots import error_over_sessions
from andante.evaluation.experiments.statistics import summary
from andante.evaluation.experiments.trials import Bench, Drive, Trial
from andante.mapping import MapConfig


def test_permutations():
    names = [f"{n}" for n in range(10)]
    orders = permutations(names, 15, 23)
    assert len(set(orders)) == 15
    assert all(sorted(order) == names for order in orders)
    assert permutations(names, 4, 23) == orders[:4]
    assert permutations(names, 4, 24) != orders[:4]


@pytest.fixture
def outcome(cache, years, tiny):
    return run_long_term(Bench(years, cache), 5, tiny, NEAREST)


def test_every_number_of_sessions_is_tested_on_the_next(outcome, years):
    orders = permutations([session.name for session in years.sessions], 2, 5)
    trials = outcome.figures["trials"]
    assert len(trials) == 2 * 2 * 2
    for trial in trials:
        size = len(trial["mapped"])
        assert any((*trial["mapped"], trial["localized"]) == order[: size + 1] for order in orders)
        assert trial["localized"] not in trial["mapped"]
    assert {len(trial["mapped"]) for trial in trials} == {1, 2}


def test_figures_are_those_of_the_trials_one_by_one(outcome, years, cache):
    orders = permutations([session.name for session in years.sessions], 2, 5)
    bench, contender = Bench(years, cache), NEAREST[0]
    for size in (1, 2):
        runs = [Trial(contender, tuple(map(Drive, order[:size])), Drive(order[size])) for order in orders]
        expected = summary(bench.run(runs)).as_dict()
        assert outcome.figures["by_sessions"]["nearest-1"][size - 1] == {"sessions": size, **expected}


def test_seasons_are_those_of_the_localized_session(outcome, years):
    orders = permutations([session.name for session in years.sessions], 2, 5)
    seasons = [years.session(order[-1]).conditions.season for order in orders]
    found = outcome.figures["by_season"]
    assert {season: row["nearest-1"]["trials"] for season, row in found.items()} == {
        season: seasons.count(season) for season in seasons
    }


def test_tables(outcome):
    overview, *each, seasons = outcome.tables
    assert overview.columns == ("sessions", "nearest-1", "nearest-5")
    assert [row[0] for row in overview.rows] == [1, 2]
    assert [table.title for table in each] == ["nearest-1", "nearest-5"]
    assert all(len(row) == len(table.columns) for table in outcome.tables for row in table.rows)
    assert sum(row[1] for row in seasons.rows) == 2
    assert "2 permutations of 3 sessions" in outcome.notes[0]


def test_another_localizer_is_one_more_entry(cache, years, tiny):
    def here(front_end, drives, config):
        return Fitted(lambda drive: np.zeros((len(drive.xy), 2)), 0)

    outcome = run_long_term(Bench(years, cache), 5, tiny, (*NEAREST, Contender("here", MapConfig(), here)))
    assert list(outcome.figures["by_sessions"]) == ["nearest-1", "nearest-5", "here"]
    assert outcome.figures["by_sessions"]["here"][0]["mean_m"] > 1


def test_the_plot_has_a_line_for_each_and_the_thesis_as_marks(outcome, cache, years, tiny):
    main, way = outcome.plots
    (axes,) = main.figure.axes
    labels = [text.get_text() for text in main.figure.legends[0].get_texts()]
    assert labels == ["nearest-1", "nearest-5", *(f"{name}, {mean:g} m" for name, mean in THESIS_AT_NINE.items())]
    assert axes.get_yscale() == "log"
    np.testing.assert_allclose(axes.lines[0].get_xdata(), [1, 2])
    assert (main.suffix, way.suffix) == ("", "way")


def test_a_perfect_localizer_can_be_drawn():
    from andante.evaluation.experiments.trials import Result

    zero = Result(np.zeros((3, 2)), np.zeros((3, 2)), 0.0, 0)
    figure = error_over_sessions({"perfect": [summary([zero])]}, {})
    figure.canvas.draw()
