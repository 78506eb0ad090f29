"""The steps of the particle filter, one by one."""

import math

import numpy as np
import pytest

from andante.data import Fix, Trajectory
from andante.localization.config import ParticleConfig
from andante.localization.motion import Step
from andante.localization.particles import Cloud
from andante.localization.sighting import sighting_of_fix
from andante.localization.trail import Trail
from andante.simulator.odometry import OdometryNoise, drifting

CONFIG = ParticleConfig(particles=4000)
HERE = sighting_of_fix(Fix(1.0, 2.0, 0.1))


def cloud(rng=None, config=CONFIG):
    return Cloud.around(HERE, Trail.empty(), config, rng or np.random.default_rng(0))


def test_they_begin_where_they_are_told_looking_anywhere():
    state = cloud().state
    assert state[:, :2].mean(axis=0) == pytest.approx([1.0, 2.0], abs=0.01)
    assert state[:, :2].std(axis=0) == pytest.approx([0.1, 0.1], rel=0.05)
    assert abs(np.exp(1j * state[:, 2]).mean()) < 0.05


def test_at_rest_nothing_changes():
    one = cloud()
    assert one.moved(Step(duration_s=5.0), CONFIG.motion, np.random.default_rng(0)) is one


def test_they_move_as_odometry_says_each_its_own_way():
    before = cloud()
    after = before.moved(Step(0.5, 0.1, 0.3, 1.0), CONFIG.motion, np.random.default_rng(0))
    way = after.state[:, :2] - before.state[:, :2]
    heading = before.state[:, 2]
    forward = way[:, 0] * np.cos(heading) + way[:, 1] * np.sin(heading)
    left = way[:, 1] * np.cos(heading) - way[:, 0] * np.sin(heading)
    assert (forward.mean(), left.mean()) == pytest.approx((0.5, 0.1), abs=0.01)
    assert np.angle(np.exp(1j * (after.state[:, 2] - heading)).mean()) == pytest.approx(0.3, abs=0.01)
    assert 0.02 < forward.std() < 0.15


def test_the_spread_after_a_drive_covers_the_drift_of_the_simulator():
    truth = np.column_stack([0.14 * np.arange(120), np.zeros(120), np.zeros(120)])
    times = 0.2 * np.arange(120)
    inside = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        odometry = drifting(Trajectory(times, truth[:, :2], truth[:, 2]), OdometryNoise(), rng)
        one = Cloud(np.zeros((800, 5)), np.full(800, 1 / 800))
        one.state[:, 3:] = rng.normal(size=(800, 2)) * [CONFIG.motion.gyro_rad_s, CONFIG.motion.scale]
        for n in range(1, 120):
            step = Step(*_relative(odometry[n - 1], odometry[n]), float(times[n] - times[n - 1]))
            one = one.moved(step, CONFIG.motion, rng)
        distance = np.hypot(*(one.state[:, :2] - one.state[:, :2].mean(axis=0)).T)
        off = np.hypot(*(truth[-1, :2] - one.state[:, :2].mean(axis=0)))
        inside.append(off <= np.quantile(distance, 0.95))
    assert sum(inside) >= 9


def _relative(before, now):
    dx, dy = now.x_m - before.x_m, now.y_m - before.y_m
    cos, sin = math.cos(before.heading_rad), math.sin(before.heading_rad)
    return cos * dx + sin * dy, cos * dy - sin * dx, now.heading_rad - before.heading_rad


def test_resampling_keeps_the_distribution_and_happens_only_where_few_carry_all():
    rng = np.random.default_rng(0)
    one = cloud()
    assert one.resampled(CONFIG, rng) is one
    likelihood = np.exp(-0.5 * ((one.state[:, 0] - 1.1) / 0.02) ** 2) + 1e-9
    weighed = one.weighed(likelihood)
    assert weighed.weight == pytest.approx(likelihood / likelihood.sum())
    drawn = weighed.resampled(CONFIG, rng)
    assert drawn.weight == pytest.approx(np.full(4000, 1 / 4000))
    assert drawn.state[:, 0].mean() == pytest.approx(weighed.weight @ weighed.state[:, 0], abs=0.002)
    # Systematic: a particle of weight w has n w copies, rounded up or down; they part by the roughening alone.
    heaviest = int(np.argmax(weighed.weight))
    near = np.hypot(*(drawn.state[:, 3:] - weighed.state[heaviest, 3:]).T) == 0
    assert abs(near.sum() - 4000 * weighed.weight[heaviest]) < 1


def test_injected_particles_carry_the_mass_they_are_given():
    there = sighting_of_fix(Fix(50.0, 0.0, 0.1))
    mixed = cloud().injected(there, Trail.empty(), 0.2, CONFIG, np.random.default_rng(0))
    far = mixed.state[:, 0] > 40
    assert far.sum() == int(CONFIG.injected_share * 4000)
    assert mixed.weight[far].sum() == pytest.approx(0.2)
    assert mixed.weight.sum() == pytest.approx(1.0)
    one = cloud()
    assert one.injected(there, Trail.empty(), 0.0, CONFIG, np.random.default_rng(0)) is one


def test_without_odometry_they_wander_with_the_root_of_time():
    before = cloud()

    def spread(duration):
        after = before.moved(Step(duration_s=duration, known=False), CONFIG.motion, np.random.default_rng(0))
        return (after.state[:, :2] - before.state[:, :2]).std()

    assert spread(1.0) == pytest.approx(CONFIG.motion.walk_m, rel=0.05)
    assert spread(4.0) == pytest.approx(2 * spread(1.0))
