"""A recording that is rendered when it is looked at."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from threading import Lock
from typing import Any

import cv2
import numpy as np

from andante.data import CameraSpec, Frame, FrameInfo, ImageArray, Pose2D
from andante.protocols import SkipCallback
from andante.recordings import iterate_frames
from andante.recordings.content import hash_content
from andante.simulator.layout import make_garden
from andante.simulator.odometry import drifting
from andante.simulator.plan import Plan
from andante.simulator.render import Renderer, Rendering

_ODOMETRY, _CLOUDS_AND_NOISE = 1, 2


class SimulatedRecording:
    """A ``Recording`` of one session of a plan; nothing is rendered before a picture is asked for.

    Raises ``ConfigError`` for an unknown session, ``MissingExtraError`` at the first picture without embreex.
    """

    def __init__(self, plan: Plan, session: str) -> None:
        self.plan, self.session = plan, plan.session(session)
        self._lock = Lock()
        self._renderer: Renderer | None = None

    def __repr__(self) -> str:
        return f"SimulatedRecording({self.name!r}, {len(self.infos)} frames)"

    @property
    def name(self) -> str:
        """The session's name."""
        return self.session.name

    @property
    def camera(self) -> CameraSpec:
        """The camera that takes all frames."""
        return self.plan.camera.spec

    @property
    def conditions(self) -> Mapping[str, Any]:
        """The session's conditions, its objects, the garden, and a fingerprint of all it depends on."""
        values = self.session.conditions.model_dump()
        garden = {f"garden_{key}": value for key, value in self.plan.garden.model_dump().items()}
        return {**values, **garden, "objects": list(self.session.objects), "plan": self.plan.fingerprint(self.name)}

    @cached_property
    def infos(self) -> Sequence[FrameInfo]:
        """True poses as references, and an odometry that drifts."""
        truth = self.session.truth(make_garden(self.plan.garden))
        odometry = drifting(truth, self.session.odometry, self.session.generator(_ODOMETRY))
        rows = zip(truth.timestamp_s + self.session.start_time_s, truth.xy_m, truth.heading_rad, odometry, strict=True)
        return tuple(
            FrameInfo(index, f"frame {index}", float(time), believed, Pose2D(float(x), float(y), float(heading)))
            for index, (time, (x, y), heading, believed) in enumerate(rows)
        )

    @property
    def renderer(self) -> Renderer:
        """Made at its first use, once, whichever thread comes first."""
        with self._lock:
            if self._renderer is None:
                seed = int(self.session.generator(_CLOUDS_AND_NOISE).integers(2**63))
                scene = self.plan.scene(self.name)
                self._renderer = Renderer(scene, self.session.conditions, self.plan.camera, seed)
            return self._renderer

    def rendering(self, index: int) -> Rendering:
        """Picture, object ids and range of frame ``index``."""
        pose = self.infos[index].reference
        assert pose is not None
        return self.renderer.render(pose, index, index / max(len(self.infos) - 1, 1))

    def load(self, info: FrameInfo, *, colour: bool = False) -> ImageArray:
        """Render one picture, BGR (height, width, 3) where ``colour`` is true, else grey (height, width)."""
        image = self.rendering(info.index).image
        return image if colour else np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)

    def frames(
        self,
        indices: Sequence[int] | None = None,
        *,
        colour: bool = False,
        on_skip: SkipCallback | None = None,
    ) -> Iterator[Frame]:
        """Render frames lazily, in order; every call starts again. Raises as ``map_frames`` does."""
        return iterate_frames(self, indices, colour=colour, on_skip=on_skip)

    def content_hash(self) -> str:
        """SHA-256 over times and poses and all that decides about the pictures, without rendering them."""
        plan = self.plan.fingerprint(self.name).encode()
        return hash_content(self.infos, (plan + str(info.index).encode() for info in self.infos))
