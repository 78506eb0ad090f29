"""All baselines of a map at once, so that they share one pass over its recordings."""

from __future__ import annotations

from collections.abc import Sequence

from andante.baselines.baseline import Baseline
from andante.baselines.nearest import NearestNeighbours
from andante.baselines.principal import PrincipalComponents
from andante.baselines.ridge import RidgeRegression
from andante.baselines.training import training_frames, training_recordings
from andante.mapping import Progress, SlowMap
from andante.protocols import Recording


def fit_baselines(
    slowmap: SlowMap, training: Sequence[Recording] = (), *, progress: Progress | None = None
) -> list[Baseline]:
    """Fit every baseline to the very frames and features that ``slowmap`` was made from.

    ``training`` holds recordings that no longer lie where the map found them; the others are opened there. Raises
    ``RecordingError`` where one of them is missing or has changed.
    """
    recordings = training_recordings(slowmap, training)
    frames = training_frames(slowmap, recordings, progress=progress)
    front_end, unit = slowmap.front_end, slowmap.unit
    return [
        NearestNeighbours.fit(front_end, unit, frames.features, frames.xy, 1),
        NearestNeighbours.fit(front_end, unit, frames.features, frames.xy, 5),
        PrincipalComponents.fit(slowmap, frames),
        RidgeRegression.fit(front_end, unit, frames.features, frames.xy),
    ]
