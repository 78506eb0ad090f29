"""A garden with seasons: renders what a robot's camera would see of it, with the truth beside.

A ``Plan`` says what to simulate; ``SimulatedRecording`` renders it on demand, ``render_plan`` to disk, and
``SimulatedRobot`` drives through it. Rays need the extra ``sim``.
"""

from andante.simulator.boxes import ObjectBox, object_boxes
from andante.simulator.camera import SimulatedCamera
from andante.simulator.conditions import Conditions
from andante.simulator.export import Progress, render_plan, render_session, render_sessions
from andante.simulator.extents import Extent, ExtentFinder, object_extent
from andante.simulator.garden import Garden, GardenSpec, Scene, Thing, Wall
from andante.simulator.layout import make_garden
from andante.simulator.odometry import Odometer, OdometryNoise
from andante.simulator.plan import Plan, Session
from andante.simulator.recording import SimulatedRecording
from andante.simulator.render import Renderer, Rendering
from andante.simulator.robot import SimulatedRobot
from andante.simulator.trajectories import BorderRun, GivenPoses, GridRun, InfieldRun
from andante.simulator.visitors import Placed

__all__ = [
    "BorderRun",
    "Conditions",
    "Extent",
    "ExtentFinder",
    "Garden",
    "GardenSpec",
    "GivenPoses",
    "GridRun",
    "InfieldRun",
    "ObjectBox",
    "Odometer",
    "OdometryNoise",
    "Placed",
    "Plan",
    "Progress",
    "Renderer",
    "Rendering",
    "Scene",
    "Session",
    "SimulatedCamera",
    "SimulatedRecording",
    "SimulatedRobot",
    "Thing",
    "Wall",
    "make_garden",
    "object_boxes",
    "object_extent",
    "render_plan",
    "render_session",
    "render_sessions",
]
