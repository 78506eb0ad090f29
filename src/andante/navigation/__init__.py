"""Where the robot is in, how it should move out: drives any ``Robot`` to a goal in a map."""

from andante.navigation.drive import Drive, Localize, drive
from andante.navigation.limits import STAND, Limits
from andante.navigation.navigator import LimitedNavigator
from andante.protocols import DriveState, Navigator, View

__all__ = ["STAND", "Drive", "DriveState", "LimitedNavigator", "Limits", "Localize", "Navigator", "View", "drive"]
