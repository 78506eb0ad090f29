"""Drives for tests: a border, odometry that drifts, features that know the place and the season."""

from types import SimpleNamespace

import numpy as np
import pytest


def border(n=200, laps=1.0, start=0.0, size_m=6.0):
    """True poses (n, 3) around a closed line without symmetry; one lap ends one step before its start."""
    angle = 2 * np.pi * (start + laps * np.arange(n) / n)
    radius = size_m * (1 + 0.12 * np.cos(angle - 0.4) + 0.1 * np.cos(2 * angle) + 0.03 * np.sin(3 * angle))
    slope = size_m * (-0.12 * np.sin(angle - 0.4) - 0.2 * np.sin(2 * angle) + 0.09 * np.cos(3 * angle))
    heading = angle + np.arctan2(radius, slope)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), heading])


def odometry(truth, rng=None, *, bias_rad=0.0, scale=1.0, turn_rad=0.0, wheel=0.0):
    """The same steps from (0, 0, 0): ``bias_rad`` a frame, ``turn_rad`` and ``wheel`` random at every step."""
    rng = rng or np.random.default_rng(0)
    step = np.diff(truth, axis=0)
    middle = (truth[1:, 2] + truth[:-1, 2]) / 2
    ahead, left = turned(step[:, 0], step[:, 1], -middle)
    turn = step[:, 2] + bias_rad + turn_rad * rng.standard_normal(len(step))
    slip = scale * (1 + wheel * rng.standard_normal(len(step)))
    heading = np.concatenate([[0.0], np.cumsum(turn)])
    x, y = turned(ahead * slip, left * slip, (heading[1:] + heading[:-1]) / 2)
    return np.column_stack([np.append(0, np.cumsum(x)), np.append(0, np.cumsum(y)), heading])


def turned(x, y, angle):
    return np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y


def placed(poses, start):
    """Poses, moved so that they begin at ``start`` (3,)."""
    x, y = turned(*(poses[:, :2] - poses[0, :2]).T, start[2] - poses[0, 2])
    return np.column_stack([x + start[0], y + start[1], poses[:, 2] + start[2] - poses[0, 2]])


def features(truth, *, garden=0, season=0, noise=0.3, dim=160):
    """Unit vectors (n, dim) that are alike within about half a metre, for any heading, shifted by the season."""
    place, weather = np.random.default_rng(garden), np.random.default_rng([garden, season, len(truth)])
    waves = place.normal(0, 2.0, (dim, 2))
    seen = np.cos(truth[:, :2] @ waves.T + place.uniform(0, 2 * np.pi, dim))
    seen = seen + weather.normal(0, 1.0, dim) + noise * weather.standard_normal((len(truth), dim))
    return (seen / np.linalg.norm(seen, axis=1, keepdims=True)).astype(np.float32)


def rigid_error_m(found, truth):
    """(n,) distances after the best rotation and translation of all of ``found``."""
    a, b = found[:, :2] - found[:, :2].mean(axis=0), truth[:, :2] - truth[:, :2].mean(axis=0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    return np.hypot(*(np.column_stack(turned(*a.T, angle)) - b).T)


@pytest.fixture(scope="session")
def drives():
    """The functions above, as tests cannot import each other."""
    return SimpleNamespace(
        border=border, odometry=odometry, placed=placed, features=features, rigid_error_m=rigid_error_m
    )
