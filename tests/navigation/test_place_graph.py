import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

from andante.data import Pose2D
from andante.errors import InputError, MapError
from andante.mapping import build_map
from andante.navigation import DriveState, Guarded, Limits, PlaceGraph, PlaceGraphNavigator, drive
from andante.navigation.place_graph import length_m

WALL = (0.0, -2.2, 0.0, 1.0)
ACROSS = (0.0, -4.0, 0.0, 4.0)


def rows(free=lambda x, y: True, spacing=0.12):
    """Drives to and fro over 6 x 4 m, cut where something is in the way."""
    drives = []
    for y in np.arange(-2.0, 2.01, spacing):
        inside = [[]]
        for x in np.arange(-3.0, 3.01, spacing):
            if free(x, y):
                inside[-1].append((x, y))
            elif inside[-1]:
                inside.append([])
        drives += [part for part in inside if part]
    return drives


def around_wall(x, y):
    return np.hypot(x, y - np.clip(y, WALL[1], WALL[3])) >= 0.3


@pytest.fixture(scope="module")
def field():
    return PlaceGraph(rows())


@pytest.fixture(scope="module")
def walled():
    return PlaceGraph(rows(around_wall))


def go(robot, truth, graph, goal, guard=True, **options):
    limits = Limits(timeout_s=options.pop("timeout_s", 120.0))
    navigator = PlaceGraphNavigator(graph, goal, limits)
    run = drive(robot, truth(robot, **options), Guarded(navigator) if guard else navigator)
    return run, navigator


def test_the_best_way_equals_bellman_ford(walled):
    prices = walled.price(walled.xy_m[walled.edges[:, 0]], walled.xy_m[walled.edges[:, 1]])
    lengths = np.full(len(walled.xy_m), np.inf)
    lengths[0] = 0.0
    for _ in range(len(lengths)):
        before = lengths.copy()
        for (a, b), step in zip(walled.edges, prices, strict=True):
            lengths[a], lengths[b] = min(lengths[a], lengths[b] + step), min(lengths[b], lengths[a] + step)
        if (before == lengths).all():
            break
    np.testing.assert_allclose(dijkstra(walled._matrix((), 0.35), directed=False, indices=0), lengths)


def test_edges_and_ways_do_not_cross_the_wall(walled):
    for a, b in walled.edges:
        line = np.linspace(walled.xy_m[a], walled.xy_m[b], 20)
        assert np.hypot(line[:, 0], line[:, 1] - np.clip(line[:, 1], WALL[1], WALL[3])).min() > 0.1
    way = walled.path((-1.0, -1.0), (1.0, -1.0))
    assert way is not None
    corner = 2 * np.hypot(1.0, 2.3)
    assert 0.95 * corner < length_m(way) < 1.15 * corner


def test_in_the_open_the_way_is_straight(field):
    way = field.path((-2.5, -1.5), (2.5, 1.5))
    assert way is not None
    assert length_m(way) == pytest.approx(np.hypot(5.0, 3.0))


def test_a_narrow_passage_is_taken_in_its_middle():
    """Two boards 0.8 m apart, to which the drives kept 0.25 m."""
    graph = PlaceGraph(rows(lambda x, y: abs(x) > 0.5 or -0.15 <= y <= 0.15, spacing=0.05))
    way = graph.path((-1.5, -1.2), (1.5, 1.2))
    assert way is not None
    along = np.interp(np.linspace(-0.4, 0.4, 9), way[:, 0], way[:, 1])
    assert np.abs(along).max() < 0.12
    assert np.abs(along).mean() < 0.06


def test_the_price_of_a_line_is_its_length_in_the_middle_and_more_at_the_rim(field):
    middle, rim, beyond = (field.price(np.array([[-1.0, y]]), np.array([[1.0, y]]))[0] for y in (0.0, 1.99, 2.15))
    assert 2.0 <= middle < 0.9 * rim
    assert rim < 0.8 * beyond


def test_something_beside_a_narrow_way_does_not_close_it_with_little_clearance():
    graph = PlaceGraph(rows(lambda x, y: abs(x) > 0.5 or -0.15 <= y <= 0.15, spacing=0.05))
    board = [(0.0, -0.2)]
    assert graph.path((-1.5, 0.0), (1.5, 0.0), board) is None
    assert graph.path((-1.5, 0.0), (1.5, 0.0), board, 0.21) is not None
    assert graph.path((-1.5, 0.0), (1.5, 0.0), [(0.0, 0.0)], 0.21) is None


def test_only_driven_ways_join_lanes_that_are_far_apart():
    lanes = PlaceGraph([[(x, 0.0) for x in np.arange(0, 5, 0.1)], [(x, 2.0) for x in np.arange(0, 5, 0.1)]])
    assert lanes.path((1.0, 0.0), (1.0, 2.0)) is None
    joined = PlaceGraph([[(x, 0.0) for x in np.arange(0, 5, 0.1)] + [(4.9, y) for y in np.arange(0, 2, 0.1)]
                         + [(x, 2.0) for x in np.arange(4.9, 0, -0.1)]])  # fmt: skip
    way = joined.path((1.0, 0.0), (1.0, 2.0))
    assert way is not None
    assert length_m(way) == pytest.approx(9.8, abs=0.5)


def test_blocked_edges_are_left_out(walled):
    gap = [(0.0, y) for y in np.arange(1.0, 2.3, 0.2)]
    assert walled.path((-1.0, 0.0), (1.0, 0.0), gap) is None


def test_goals_off_the_map_are_refused(field):
    with pytest.raises(InputError, match=r"the goal \(9\.00, 0\.00\) is 6\.\d m from everything that was mapped"):
        PlaceGraphNavigator(field, Pose2D(9.0, 0.0))
    with pytest.raises(InputError, match=r"at least one driven position"):
        PlaceGraph([])


def test_a_map_that_remembers_its_drives_makes_a_graph(garden):
    slowmap = build_map(garden.two_days())
    graph = PlaceGraph.of(slowmap)
    way = graph.path(slowmap.memory[0].xy[0], slowmap.memory[0].xy[20])
    assert way is not None
    assert 5.0 < length_m(way) < 7.5  # along the loop, not across it
    with pytest.raises(MapError, match=r"does not remember its drives; load it with its memory"):
        PlaceGraph.of(replace(slowmap, memory=None))
    with pytest.raises(InputError, match=r"numbered places, not positions"):
        PlaceGraph.of(replace(slowmap, unit="place"))


@pytest.mark.parametrize("heading", [True, False])
def test_arrives_in_the_open(field, flat_robot, truth, heading):
    rng = np.random.default_rng(1)
    for seed in range(8):
        start, goal = rng.uniform((-2.8, -1.8), (2.8, 1.8), (2, 2))
        robot = flat_robot((*start, rng.uniform(-3, 3)), drift=1.03)
        run, _ = go(robot, truth, field, Pose2D(*goal), sigma_m=0.1, sigma_rad=0.1, heading=heading, seed=seed)
        assert run.arrived, run.reason
        assert np.hypot(*(robot.pose[:2] - goal)) < 0.5


def test_arrives_around_the_wall_without_touching_it(walled, flat_robot, truth):
    rng = np.random.default_rng(2)
    for seed in range(8):
        start, goal = (-1.5, rng.uniform(-1.8, 0.5)), (1.5, rng.uniform(-1.8, 0.5))
        robot = flat_robot((*start, rng.uniform(-3, 3)), [WALL], reach_m=1.5)
        run, _ = go(robot, truth, walled, Pose2D(*goal), sigma_m=0.1, sigma_rad=0.1, seed=seed)
        assert run.arrived, run.reason
        assert np.hypot(*(robot.pose[:2] - goal)) < 0.5
        assert robot.bumps == 0


def test_turns_to_the_heading_of_the_goal(field, flat_robot, truth):
    robot = flat_robot((-1.0, 0.0, 0.0))
    run, _ = go(robot, truth, field, Pose2D(1.0, 0.0, 2.0))
    assert run.arrived
    assert abs(robot.pose[2] % (2 * np.pi) - 2.0) < 0.3


@pytest.mark.parametrize(("reach_m", "guard"), [(1.5, True), (None, True), (None, False)])
def test_replans_where_a_wall_is_new(field, flat_robot, truth, reach_m, guard):
    robot = flat_robot((-1.5, 0.0, 0.0), [(0.0, -1.0, 0.0, 1.0)], reach_m=reach_m)
    run, navigator = go(robot, truth, field, Pose2D(1.5, 0.0), guard)
    assert run.arrived, run.reason
    assert navigator.replans > 0
    assert (robot.bumps == 0) == (reach_m is not None)


def test_says_when_there_is_no_other_way(field, flat_robot, truth):
    robot = flat_robot((-1.5, 0.0, 0.0), [ACROSS], reach_m=1.5)
    run, _ = go(robot, truth, field, Pose2D(1.5, 0.0), timeout_s=900.0)
    assert run.outcome == DriveState.BLOCKED
    assert "every mapped way" in run.reason


def test_something_at_the_goal_is_told_soon(field, flat_robot, truth):
    robot = flat_robot((-1.5, 0.0, 0.0), [(1.5, -0.1, 1.5, 0.1)], reach_m=1.5)
    run, navigator = go(robot, truth, field, Pose2D(1.5, 0.0), timeout_s=900.0)
    assert (run.outcome, run.reason) == (DriveState.BLOCKED, "something stands at the goal")
    assert robot.bumps == 0
    assert run.seconds < 120.0
    assert navigator.replans <= 10  # not one for every control step


def test_plans_are_kept_for_those_who_ask(field, flat_robot, truth):
    robot = flat_robot((-1.5, 0.0, 0.0), [(0.0, -1.0, 0.0, 1.0)], reach_m=1.5)
    _, navigator = go(robot, truth, field, Pose2D(1.5, 0.0))
    times = [time_s for time_s, _ in navigator.plans]
    assert times == sorted(times)
    assert len(times) > navigator.replans > 0
    for _, way in navigator.plans:
        assert way[-1] == pytest.approx([1.5, 0.0])


def test_time_runs_out(field, flat_robot, truth):
    run, _ = go(flat_robot((-2.5, 0.0, 0.0)), truth, field, Pose2D(2.5, 0.0), timeout_s=2.0)
    assert run.outcome == DriveState.TIMED_OUT


def test_stops_when_told(field, flat_robot, truth):
    robot = flat_robot((-2.5, 0.0, 0.0))
    navigator = PlaceGraphNavigator(field, Pose2D(2.5, 0.0))
    steps = itertools.count()
    run = drive(
        robot, truth(robot), navigator, progress=lambda *_: navigator.stop("enough") if next(steps) == 5 else None
    )
    assert (run.outcome, run.reason, len(run)) == (DriveState.STOPPED, "enough", 6)


@pytest.mark.parametrize(
    "lost", [lambda s: s < 4.0, lambda s: 3.0 < s < 5.0, lambda s: 3.0 < s < 30.0, lambda s: int(5 * s) % 4 > 0]
)
def test_lost_estimates_are_bridged_or_waited_for(field, flat_robot, truth, lost):
    robot = flat_robot((-2.5, 0.5, 2.0))
    run, _ = go(robot, truth, field, Pose2D(2.5, -0.5), sigma_m=0.05, sigma_rad=0.05, lost=lost)
    assert run.arrived, run.reason
    assert np.hypot(*(robot.pose[:2] - (2.5, -0.5))) < 0.5


def test_never_a_pose_is_no_drive_into_the_blue(field, flat_robot, truth):
    robot = flat_robot((0.0, 0.0, 0.0))
    run, _ = go(robot, truth, field, Pose2D(2.5, 0.0), lost=lambda s: True, timeout_s=40.0)
    assert run.outcome == DriveState.TIMED_OUT
    assert np.abs(run.command[:, 0]).max() <= 0.2
