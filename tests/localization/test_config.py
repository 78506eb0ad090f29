"""Configurations say what is wrong with them."""

import pytest

from andante.errors import ConfigError
from andante.localization import KalmanConfig, ParticleConfig
from andante.localization.config import MotionConfig


def test_they_are_frozen_and_nested():
    config = ParticleConfig(motion=MotionConfig(max_speed_m_s=1.0))
    assert config.motion.max_speed_m_s == 1.0
    with pytest.raises(ValueError, match="frozen"):
        config.particles = 9


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"particles": 3}, "particles = 3 is not allowed"),
        ({"particle": 300}, "particle = 300 is not allowed"),
        ({"motion": {"scale": -1}}, r"motion\.scale = -1 is not allowed"),
        ({"sighting": {"floor_ok": float("nan")}}, r"sighting\.floor_ok = nan"),
    ],
)
def test_mistakes_name_their_key(values, message):
    with pytest.raises(ConfigError, match=message):
        ParticleConfig(**values)


def test_kalman_too():
    with pytest.raises(ConfigError, match="rejections"):
        KalmanConfig(rejections=1)
