"""Drives of which only odometry is known, brought into one frame of reference: that of the first one.

Each drive has a frame of its own, in which it drifts. It is closed on itself where it comes back to where it began, and
laid over the drives before it by what it sees (``andante.sequences``). A drive never moves those before it, so a map
that is updated is the map that would have been built from all at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from andante.data import FloatArray, Trajectory
from andante.errors import ArrayError, RecordingError
from andante.mapping.config import DriftConfig
from andante.mapping.memory import MappedSession
from andante.protocols import Recording
from andante.sequences import DriftNoise, RegisteredSession, SessionReport, register_session


@dataclass(frozen=True, slots=True)
class Closing:
    """How far a drive's odometry was from closing, and how its frames agreed with those of the drives before.

    ``heading_error_rad`` and ``position_error_m`` are ``None`` for a drive that does not close; ``kept`` and
    ``rejected`` count correspondences with earlier drives, ``residual_m`` is the median distance of those kept, all
    three ``None`` for the first one. ``hint`` says why the first drive was left as its odometry has it, empty where it
    was not.
    """

    name: str
    heading_error_rad: float | None = None
    position_error_m: float | None = None
    kept: int | None = None
    rejected: int | None = None
    residual_m: float | None = None
    hint: str = ""

    @classmethod
    def of(cls, name: str, report: SessionReport) -> Closing:
        """What is told of a registration."""
        loop, first = report.closing, report.registration is None
        return cls(
            name,
            None if loop is None else loop.heading_error_rad,
            None if loop is None else loop.position_error_m,
            None if first else report.kept,
            None if first else report.rejected,
            None if first else report.residual_m,
        )


def in_one_frame(
    earlier: Sequence[MappedSession], new: Sequence[tuple[MappedSession, Recording]], drift: DriftConfig
) -> tuple[list[MappedSession], list[Closing]]:
    """The new drives in the frame of the earlier ones, which stay as they are, and how they came there.

    Where there are no earlier ones, the first new drive makes the frame; one that does not come back to where it began
    is left as its odometry has it. Raises ``RecordingError`` naming a drive that does not fit those before it.
    """
    noise = DriftNoise(**drift.model_dump())
    known = [RegisteredSession(one.codes.rows(), one.poses, SessionReport(None)) for one in earlier]
    placed, closings = list[MappedSession](), list[Closing]()
    for session, recording in new:
        name, features = session.source.name, session.codes.rows()
        try:
            odometry, times = _odometry(session, recording)
            registered = register_session(features, odometry, times, earlier=known, noise=noise)
            closings.append(Closing.of(name, registered.report))
        except (RecordingError, ArrayError) as error:
            if known:
                raise RecordingError(f"recording {name!r} cannot be placed by its odometry: {error}") from None
            registered = RegisteredSession(features, session.poses, SessionReport(None))
            closings.append(Closing(name, hint=f"{name} is mapped as its odometry has it, drift and all: {error}"))
        known.append(registered)
        placed.append(replace(session, xy=registered.xy_m.copy(), heading_rad=registered.heading_rad.copy()))
    return placed, closings


def _odometry(session: MappedSession, recording: Recording) -> tuple[FloatArray, FloatArray]:
    """Odometry (n, 3) and times (n,) of the mapped frames; raises ``RecordingError`` where headings are unknown."""
    infos = [recording.infos[index] for index in session.number.tolist()]
    driven = Trajectory.of(infos, "odometry")
    if not np.isfinite(driven.heading_rad).all():
        raise RecordingError(
            "its headings are unknown (odom_heading_rad of frames.csv is blank); fill them in or map it alone"
        )
    return np.column_stack([driven.xy_m, driven.heading_rad]), driven.timestamp_s
