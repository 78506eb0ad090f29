"""What a map remembers of its drives, so that it can learn again when another one comes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, IndexArray
from andante.mapping.codes import Codes
from andante.mapping.config import Positions
from andante.mapping.thinning import thinned_by_place


@dataclass(frozen=True)
class Source:
    """One recording that a map was made from.

    ``content_hash`` tells it from all others; ``folder`` says where it was found, for comparisons that need its
    images again; ``poses`` is which of its poses were learnt from, reference, odometry or place; ``frames`` is how many
    of its pictures are in the map.
    """

    name: str
    content_hash: str
    frames: int
    poses: Positions
    conditions: Mapping[str, Any] = field(default_factory=dict)
    skipped: tuple[str, ...] = ()
    folder: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class MappedSession:
    """One drive as learning sees it, n frames: features, positions and where it came from.

    ``codes`` are n feature vectors and ``phase`` n phase signatures; ``xy`` (n, 2) positions in the map's frame, in
    metres, or the place number and zero; ``heading_rad`` (n,), NaN where unknown; ``number`` (n,) the frames of the
    recording; ``pictures`` (n,) uint32 fingerprints.
    """

    source: Source
    codes: Codes
    phase: Codes
    xy: FloatArray
    heading_rad: FloatArray
    number: IndexArray
    pictures: NDArray[np.uint32]

    def __len__(self) -> int:
        return len(self.xy)

    def subset(self, chosen: IndexArray | NDArray[np.bool_]) -> MappedSession:
        """Some of the frames."""
        xy = self.xy[chosen]
        return MappedSession(
            replace(self.source, frames=len(xy)),
            self.codes.subset(chosen),
            self.phase.subset(chosen),
            xy,
            self.heading_rad[chosen],
            self.number[chosen],
            self.pictures[chosen],
        )

    @property
    def poses(self) -> FloatArray:
        """(n, 3) positions and headings."""
        return np.column_stack([self.xy, self.heading_rad])


def bounded(sessions: Sequence[MappedSession], at_most: int) -> list[MappedSession]:
    """At most so many frames, spread over the places and sessions that they stand for; sessions left empty are gone."""
    lengths = [len(session) for session in sessions]
    if sum(lengths) <= at_most:
        return list(sessions)
    xy = np.concatenate([session.xy for session in sessions])
    kept = np.zeros(len(xy), dtype=np.bool_)
    kept[thinned_by_place(xy, np.repeat(np.arange(len(sessions)), lengths), at_most)] = True
    parts = zip(sessions, np.split(kept, np.cumsum(lengths)[:-1]), strict=True)
    return [session.subset(chosen) for session, chosen in parts if chosen.any()]


def memory_arrays(sessions: Sequence[MappedSession]) -> dict[str, NDArray[Any]]:
    """The arrays of all sessions by name, for a file; their sources go into its header."""
    return {
        **Codes.joined([session.codes for session in sessions]).to_arrays(),
        **{f"phase.{k}": v for k, v in Codes.joined([session.phase for session in sessions]).to_arrays().items()},
        "xy": np.concatenate([session.xy for session in sessions]),
        "heading": np.concatenate([session.heading_rad for session in sessions]),
        "number": np.concatenate([session.number for session in sessions]),
    }


def memory_of(
    arrays: Mapping[str, NDArray[Any]], sources: Sequence[Source], pictures: Sequence[NDArray[np.uint32]]
) -> tuple[MappedSession, ...]:
    """The inverse, for arrays that fit the sources (see ``consistency.check_memory``)."""
    codes, phase = Codes.from_arrays(arrays), phase_of(arrays)
    xy, heading, number = arrays["xy"], arrays["heading"], arrays["number"]
    return tuple(
        MappedSession(source, codes.subset(rows), phase.subset(rows), xy[rows], heading[rows], number[rows], own)
        for source, rows, own in zip(sources, rows_of(sources), pictures, strict=True)
    )


def phase_of(arrays: Mapping[str, NDArray[Any]]) -> Codes:
    """The phase signatures among the arrays of a memory."""
    return Codes.from_arrays({name: arrays[f"phase.{name}"] for name in ("codes", "scale")})


def rows_of(sources: Sequence[Source]) -> list[slice]:
    """Where the frames of each source lie among those of all."""
    ends = np.cumsum([source.frames for source in sources]).tolist()
    return [slice(end - source.frames, end) for source, end in zip(sources, ends, strict=True)]
