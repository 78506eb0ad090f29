"""Andante maps a place from slow features and says where a robot is from one image.

The names below are loaded when they are first used, so that ``import andante`` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from andante.data import CameraSpec as CameraSpec
    from andante.data import Estimate as Estimate
    from andante.data import Fix as Fix
    from andante.data import Frame as Frame
    from andante.data import FrameInfo as FrameInfo
    from andante.data import Hypothesis as Hypothesis
    from andante.data import Pose2D as Pose2D
    from andante.data import Status as Status
    from andante.data import Trajectory as Trajectory
    from andante.errors import AndanteError as AndanteError
    from andante.evaluation import Evaluation as Evaluation
    from andante.evaluation import Track as Track
    from andante.evaluation import evaluate as evaluate
    from andante.evaluation import run_localizer as run_localizer
    from andante.evaluation import track as track
    from andante.evaluation import write_report as write_report
    from andante.evaluation import write_track_report as write_track_report
    from andante.export import export_onnx as export_onnx
    from andante.localization import make_tracker as make_tracker
    from andante.mapping import BuildLog as BuildLog
    from andante.mapping import MapConfig as MapConfig
    from andante.mapping import SlowMap as SlowMap
    from andante.mapping import build_map as build_map
    from andante.mapping import merge_maps as merge_maps
    from andante.mapping import update_map as update_map
    from andante.navigation import Goal as Goal
    from andante.navigation import Guarded as Guarded
    from andante.navigation import Limits as Limits
    from andante.navigation import PlaceGraph as PlaceGraph
    from andante.navigation import PlaceGraphNavigator as PlaceGraphNavigator
    from andante.navigation import drive as drive
    from andante.navigation import image_goal as image_goal
    from andante.navigation import named_goal as named_goal
    from andante.navigation import pose_goal as pose_goal
    from andante.navigation import tracked as tracked
    from andante.protocols import Localizer as Localizer
    from andante.protocols import Navigator as Navigator
    from andante.protocols import Recording as Recording
    from andante.protocols import Robot as Robot
    from andante.protocols import View as View
    from andante.recordings import MemoryRecording as MemoryRecording
    from andante.recordings import open_images as open_images
    from andante.recordings import open_recording as open_recording
    from andante.recordings import read_image as read_image
    from andante.recordings import register_format as register_format
    from andante.recordings import write_recording as write_recording

    __version__: str

_NAMES_OF = {
    "data": ("CameraSpec", "Estimate", "Fix", "Frame", "FrameInfo", "Hypothesis", "Pose2D", "Status", "Trajectory"),
    "errors": ("AndanteError",),
    "evaluation": (
        "Evaluation",
        "Track",
        "evaluate",
        "run_localizer",
        "track",
        "write_report",
        "write_track_report",
    ),
    "export": ("export_onnx",),
    "localization": ("make_tracker",),
    "mapping": ("BuildLog", "MapConfig", "SlowMap", "build_map", "merge_maps", "update_map"),
    "navigation": (
        "Goal",
        "Guarded",
        "Limits",
        "PlaceGraph",
        "PlaceGraphNavigator",
        "drive",
        "image_goal",
        "named_goal",
        "pose_goal",
        "tracked",
    ),
    "protocols": ("Localizer", "Navigator", "Recording", "Robot", "View"),
    "recordings": (
        "MemoryRecording",
        "open_images",
        "open_recording",
        "read_image",
        "register_format",
        "write_recording",
    ),
}
_ROOM_OF = {name: room for room, names in _NAMES_OF.items() for name in names}

__all__ = [
    "AndanteError",
    "BuildLog",
    "CameraSpec",
    "Estimate",
    "Evaluation",
    "Fix",
    "Frame",
    "FrameInfo",
    "Goal",
    "Guarded",
    "Hypothesis",
    "Limits",
    "Localizer",
    "MapConfig",
    "MemoryRecording",
    "Navigator",
    "PlaceGraph",
    "PlaceGraphNavigator",
    "Pose2D",
    "Recording",
    "Robot",
    "SlowMap",
    "Status",
    "Track",
    "Trajectory",
    "View",
    "__version__",
    "build_map",
    "drive",
    "evaluate",
    "export_onnx",
    "image_goal",
    "make_tracker",
    "merge_maps",
    "named_goal",
    "open_images",
    "open_recording",
    "pose_goal",
    "read_image",
    "register_format",
    "run_localizer",
    "track",
    "tracked",
    "update_map",
    "write_recording",
    "write_report",
    "write_track_report",
]


if not TYPE_CHECKING:  # a type checker that sees this would believe in any name

    def __getattr__(name: str) -> object:
        """Load a public name when it is first asked for (PEP 562); afterwards it is a plain attribute."""
        if name == "__version__":
            from importlib.metadata import version

            value = version("andante")
        elif name in _ROOM_OF:
            value = getattr(import_module(f"andante.{_ROOM_OF[name]}"), name)
        else:
            raise AttributeError(f"module 'andante' has no attribute {name!r}")
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
