"""Which frames are held out together: whole sessions, or blocks of a single one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from andante.data import IndexArray
from andante.mapping.config import CalibrationConfig
from andante.mapping.learning import Ground

FoldKind = Literal["sessions", "blocks"]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Folds:
    """n frames in as many parts as there are ``labels``; ``fold_of`` (n,) says in which each is.

    ``members`` are the sessions of each part, by number.
    """

    kind: FoldKind
    fold_of: IndexArray
    labels: tuple[str, ...]
    members: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, ground: Ground, names: Sequence[str], config: CalibrationConfig) -> Folds:
        """Sessions left out one by one, or in groups where there are more than ``config.folds``.

        A single session is cut into blocks, which cannot tell what another light or season will do.
        """
        sessions = np.unique(ground.session)
        if len(sessions) > 1:
            count = min(len(sessions), config.folds)
            fold_of = np.searchsorted(sessions, ground.session) % count
            members = tuple(tuple(sessions[fold::count].tolist()) for fold in range(count))
            return cls("sessions", fold_of, tuple(" + ".join(names[s] for s in part) for part in members), members)
        # Long enough that the neighbours of most frames are gone, short enough that a place remains near.
        block = config.block_m or 4 * ground.radius
        steps = np.linalg.norm(np.diff(ground.xy, axis=0), axis=1)
        travelled = np.concatenate([[0.0], np.cumsum(steps)])
        fold_of = (travelled // block).astype(np.int64) % config.folds
        labels = tuple(f"blocks {fold + 1} of {config.folds}" for fold in range(config.folds))
        return cls("blocks", fold_of, labels, ((0,),) * config.folds)

    def __iter__(self) -> Iterator[tuple[Mask, Mask]]:
        """Masks (n,) of the frames to learn from and of those held out, for every part."""
        for fold in range(len(self.labels)):
            held_out = self.fold_of == fold
            yield ~held_out, held_out
