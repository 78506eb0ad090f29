import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.errors import ConfigError
from andante.navigation import STAND, Limits
from andante.protocols import VelocityCommand

LIMITS = Limits(forward_m_s=0.5, turn_rad_s=1.0, acceleration_m_s2=1.0, turn_acceleration_rad_s2=4.0)
SPEED = st.floats(-3, 3)


@given(wanted=SPEED, turn=SPEED, before=st.floats(-0.5, 0.5), seconds=st.floats(0, 1))
def test_neither_speed_nor_its_growth_exceeds_the_limits(wanted, turn, before, seconds):
    held = LIMITS.held(VelocityCommand(wanted, turn), VelocityCommand(before, 0.0), seconds)
    assert abs(held.forward_m_s) <= 0.5
    assert abs(held.turn_rad_s) <= 1.0
    assert abs(held.forward_m_s) <= abs(before) + seconds + 1e-12
    assert abs(held.turn_rad_s) <= 4.0 * seconds + 1e-12


def test_slowing_down_is_free():
    assert LIMITS.held(STAND, VelocityCommand(0.5, -1.0), 0.0) == STAND


@pytest.mark.parametrize(("key", "value"), [("forward_m_s", 0.0), ("timeout_s", -1.0), ("turn_rad_s", float("nan"))])
def test_limits_are_positive(key, value):
    with pytest.raises(ConfigError, match=rf"{key} = {value} is not allowed; limits are finite and greater than 0"):
        Limits(**{key: value})
