"""Where the robot is in, how it should move out: drives any ``Robot`` to a goal in a map."""

from andante.navigation.commute import CommuteNavigator, CommuteSettings
from andante.navigation.drive import Drive, Localize, drive, tracked
from andante.navigation.goals import Goal, image_goal, named_goal, places_file, pose_goal
from andante.navigation.gradient import GradientNavigator, GradientSettings
from andante.navigation.graph_navigator import PlaceGraphNavigator
from andante.navigation.guard import Guarded
from andante.navigation.limits import STAND, Limits
from andante.navigation.navigator import LimitedNavigator
from andante.navigation.place_graph import PlaceGraph
from andante.navigation.sight import KERNEL_SIGHT, THESIS_SIGHT, SightRecipe, SlowSight, learn_sight
from andante.navigation.slow_cost import SlowCost
from andante.protocols import DriveState, Navigator, View

__all__ = [
    "KERNEL_SIGHT",
    "STAND",
    "THESIS_SIGHT",
    "CommuteNavigator",
    "CommuteSettings",
    "Drive",
    "DriveState",
    "Goal",
    "GradientNavigator",
    "GradientSettings",
    "Guarded",
    "LimitedNavigator",
    "Limits",
    "Localize",
    "Navigator",
    "PlaceGraph",
    "PlaceGraphNavigator",
    "SightRecipe",
    "SlowCost",
    "SlowSight",
    "View",
    "drive",
    "image_goal",
    "learn_sight",
    "named_goal",
    "places_file",
    "pose_goal",
    "tracked",
]
