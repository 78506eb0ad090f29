import numpy as np
import pytest

from andante.data import Pose2D
from andante.errors import ConfigError
from andante.protocols import Robot, VelocityCommand
from andante.simulator import GardenSpec, OdometryNoise, Scene, SimulatedCamera, SimulatedRobot, make_garden
from andante.simulator.obstacles import Obstacles

SILENT = OdometryNoise(scale=0, gyro_rad_s=0, wheel_m=0, turn_rad=0)
CAMERA = SimulatedCamera(width_px=16, height_px=16, antialias=False)


@pytest.fixture(scope="module")
def walled(embree):
    """A garden with one wall across x = 2 and one closed block around (-3, 0)."""
    scene = Scene.of(make_garden(GardenSpec(seed=3)).things[:1])
    walls = Obstacles(np.array([(2.0, 0.0, 0.0, 0.1, 5.0), (-3.0, 0.0, 0.0, 0.5, 0.5)]))
    return Scene(scene.mesh, scene.object_id, scene.names, walls)


def robot(scene, x=0.0, y=0.0, heading=0.0):
    return SimulatedRobot(scene, Pose2D(x, y, heading), camera=CAMERA, noise=SILENT)


def test_it_is_a_robot(walled):
    made = robot(walled)
    assert isinstance(made, Robot)
    assert made.camera == CAMERA.spec


def test_it_drives_arcs(walled):
    made = robot(walled, y=-2.0)
    seen = made.step(VelocityCommand(0.5, np.pi / 2), 2.0)  # half a circle of radius 1 / pi
    assert seen.timestamp_s == 2.0
    assert not seen.bumped
    assert seen.image.shape == (16, 16, 3)
    assert (made.pose.x_m, made.pose.y_m) == pytest.approx((0.0, -2.0 + 2 / np.pi), abs=0.01)
    assert made.pose.heading_rad == pytest.approx(np.pi)
    assert (seen.odometry.x_m, seen.odometry.y_m) == pytest.approx((0.0, 2 / np.pi), abs=0.01)


def test_it_stops_at_a_wall_even_when_it_is_fast_and_can_back_off(walled):
    made = robot(walled)
    assert made.step(VelocityCommand(50.0, 0.0), 1.0).bumped
    assert made.pose.x_m == pytest.approx(1.7, abs=0.025)  # its radius is 0.2 m, the wall's face at 1.9 m
    assert not made.stuck
    assert not made.step(VelocityCommand(-0.5, 0.0), 1.0).bumped
    assert made.pose.x_m == pytest.approx(1.2, abs=0.03)


def test_odometry_counts_only_what_was_driven(walled):
    made = robot(walled)
    seen = made.step(VelocityCommand(1.0, 0.0), 10.0)
    assert seen.odometry.x_m == pytest.approx(made.pose.x_m)


def test_inside_of_something_it_knows_and_only_gets_out(walled):
    made = robot(walled, x=-3.2)
    assert made.stuck
    assert made.step(VelocityCommand(0.0, 0.0), 0.1).bumped
    deeper = made.step(VelocityCommand(0.3, 0.0), 0.5)
    assert deeper.bumped
    assert made.pose.x_m == pytest.approx(-3.2)
    out = made.step(VelocityCommand(-1.0, 0.0), 1.0)
    assert not out.bumped
    assert made.pose.x_m == pytest.approx(-4.2, abs=0.01)


@pytest.mark.parametrize(("speed", "duration"), [(np.nan, 1.0), (1.0, np.inf), (1.0, -0.1)])
def test_impossible_steps_are_refused(walled, speed, duration):
    with pytest.raises(ConfigError, match="a step needs finite numbers and a duration_s of 0 or more"):
        robot(walled).step(VelocityCommand(speed, 0.0), duration)


def test_the_range_sensor_looks_as_wide_as_the_robot_straight_ahead(walled):
    def seen(x, y, heading):
        made = SimulatedRobot(walled, Pose2D(x, y, heading), camera=CAMERA, noise=SILENT, range_reach_m=1.5)
        return made.step(VelocityCommand(0.0, 0.0), 0.1).range_m

    assert seen(0.5, 0.0, 0.0) == pytest.approx(1.9 - 0.25 - 0.5, abs=0.02)  # to the wall's face, less the robot
    assert seen(0.5, 0.0, np.pi / 2) == 1.5
    assert robot(walled).step(VelocityCommand(0.0, 0.0), 0.1).range_m is None
