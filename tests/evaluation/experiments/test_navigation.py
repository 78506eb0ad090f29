import json

import numpy as np
import pytest

from andante.evaluation.experiments import Scale, run_experiment
from andante.evaluation.experiments.cache import rendered
from andante.evaluation.experiments.navigation import figures_of
from andante.evaluation.experiments.navigation_maps import SEEN_BY, CostMap, cost_maps, travel_correlations
from andante.evaluation.experiments.navigation_trials import (
    DRIVERS,
    KERNEL,
    MAP,
    THESIS,
    Result,
    Task,
    World,
    run_tasks,
)
from andante.evaluation.experiments.navigation_world import GRID, MAPPED, Errand, Lawn, navigation_plan
from andante.mapping import build_map
from andante.navigation import KERNEL_SIGHT, THESIS_SIGHT, Limits, learn_sight
from andante.simulator import make_garden


@pytest.fixture(scope="module")
def plan():
    return navigation_plan(5, Scale(frames=400, image_px=60), obstacle=False)


@pytest.fixture(scope="module")
def recordings(embree, plan, tmp_path_factory):
    return rendered(plan, tmp_path_factory.mktemp("lawn"))


@pytest.fixture(scope="module")
def sights(recordings):
    return {
        name: learn_sight(recordings[MAPPED], recipe)
        for name, recipe in ((THESIS, THESIS_SIGHT), (KERNEL, KERNEL_SIGHT))
    }


@pytest.fixture(scope="module")
def lawn(plan):
    return Lawn(make_garden(plan.garden))


def test_every_driver_drives(plan, recordings, sights):
    world = World(plan.garden, plan.camera, plan.sessions[0].conditions)
    errand = Errand((0.0, -1.0, 1.0), (0.5, 1.0), 2.1)
    keyed = {("lawn", name): sight for name, sight in sights.items()}
    keyed["lawn", MAP] = build_map([recordings[MAPPED]])
    told = []
    results = run_tasks(
        [Task(driver.name, "lawn", world, errand, 3) for driver in DRIVERS],
        keyed,
        progress=lambda stage, done, total: told.append((stage, done, total)),
    )
    assert told[-1] == ("drives", len(DRIVERS), len(DRIVERS))
    for result in results:
        np.testing.assert_allclose(result.xy_m[0], errand.start[:2])
        assert result.distance_m == pytest.approx(np.hypot(*(result.xy_m[-1] - errand.goal)))
        assert result.way_m > 0.5
        assert len(result.milliseconds) > 0
    again = run_tasks([Task(DRIVERS[0].name, "lawn", world, errand, 3)], keyed)[0]
    np.testing.assert_array_equal(again.xy_m, results[0].xy_m)


def test_a_goal_off_the_map_is_a_drive_that_did_not_arrive(plan, recordings):
    world = World(plan.garden, plan.camera, plan.sessions[0].conditions)
    errand = Errand((0.0, -1.0, 1.0), (90.0, -1.0), 90.0)
    slowmap = build_map([recordings[MAPPED]])
    result = run_tasks([Task("place graph", "lawn", world, errand, 3)], {("lawn", MAP): slowmap})[0]
    assert (result.state, result.distance_m) == ("refused", 90.0)
    assert "from everything that was mapped" in result.reason
    assert figures_of([result], [errand])["milliseconds"] is None


def test_the_experiment_writes_its_files(embree, monkeypatch, tmp_path):
    monkeypatch.setattr("andante.evaluation.experiments.navigation_trials.LIMITS", Limits(timeout_s=4.0))
    written = run_experiment(
        "navigation", tmp_path, scale=Scale(frames=200, image_px=48), cache=tmp_path / "cache", seed=5
    )
    values = json.loads(written.json.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    cases = values["figures"]["cases"]
    assert [len(cases[f"{lawn}, four pairs"]) for lawn in ("in the open", "around the obstacle")] == [4, 4]
    assert cases["in the open, four pairs"]["andante's gradient"]["drives"] == 4
    assert "the obstacle moved by 0.9 m" in cases
    assert len(written.plots) == 4
    assert "EP3367061B1" in written.page.read_text(encoding="utf-8")


def test_slow_features_know_how_far_it_is(recordings, sights, lawn):
    costs = cost_maps(sights, recordings[GRID], np.zeros(2))
    found = travel_correlations(costs, lawn)
    assert list(found) == [by.name for by in SEEN_BY]
    assert found["kernel features, biharmonic"] > 0.5


def test_a_perfect_cost_correlates_perfectly(lawn):
    xy = lawn.xy_m[::7]
    perfect = CostMap(SEEN_BY[0], np.ones(2), xy, xy.copy(), xy[0])
    assert travel_correlations([perfect], lawn)[SEEN_BY[0].name] > 0.99
    assert perfect.cost_to(xy[5])[5] == 0.0


def test_figures_are_of_all_drives_and_ways_of_those_that_arrived():
    errands = [Errand((0.0, 0.0, 0.0), (4.0, 0.0), 4.0)] * 4
    results = [
        Result(end, hits, way, 10.0, "arrived", "", np.zeros((2, 2)), np.ones(3))
        for end, hits, way in ((0.1, 0, 5.0), (0.4, 0, 6.0), (0.6, 1, 9.0), (3.0, 0, 50.0))
    ]
    figures = figures_of(results, errands)
    assert [figures[f"within_{limit}_m"] for limit in (0.3, 0.5, 0.8, 1.0)] == [0.25, 0.5, 0.75, 0.75]
    assert figures["hit"] == 0.25
    assert figures["way_over_shortest"] == pytest.approx(5.5 / 4.0)
    assert figures["states"] == {"arrived": 4}
