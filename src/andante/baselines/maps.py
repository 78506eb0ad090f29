"""Maps of slow features as compared methods: the package's own choices, and the thesis'."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from andante.baselines.baseline import Seen, seen_by
from andante.baselines.method import Learned
from andante.data import Estimate, ImageArray, PoseSource, Status
from andante.errors import BlankImageError
from andante.mapping import BuildLog, MapConfig, Progress, SlowMap, build_map
from andante.protocols import Recording
from andante.recordings import iterate_frames


@dataclass(frozen=True)
class MapLocalizer:
    """A map in the two steps of a ``StagedLocalizer``."""

    name: str
    slowmap: SlowMap = field(repr=False)

    def localize(self, image: ImageArray) -> Estimate:
        """As ``SlowMap.localize``."""
        return self.locate(self.prepare(image))

    def prepare(self, image: ImageArray) -> Seen:
        """Panorama, features and phases."""
        return seen_by(self.slowmap.front_end, image)

    def locate(self, prepared: Seen) -> Estimate:
        """What the map says of them."""
        if isinstance(prepared, BlankImageError):
            return Estimate(Status.LOST, str(prepared))
        return self.slowmap.estimate(prepared)


@dataclass(frozen=True)
class MapMethod:
    """A ``Method``: a map that is built with a configuration."""

    name: str = "andante"
    config: MapConfig = field(default_factory=MapConfig, repr=False)

    def learn(
        self, recordings: Sequence[Recording], *, positions: PoseSource = "reference", progress: Progress | None = None
    ) -> Learned:
        """Raises as ``build_map`` does. What the first image waits for, the imagined views, counts as mapping."""
        config, log, start = self.config.with_values({"positions": positions}), BuildLog(), time.perf_counter()
        slowmap = build_map(recordings, config, name=self.name, progress=progress, log=log)
        built = time.perf_counter()
        for frame in iterate_frames(recordings[0], [0], workers=1):
            slowmap.localize(frame.image)
        first_s = time.perf_counter() - built
        learning_s = log.seconds["learn"] + log.seconds["readout"]
        return Learned(
            MapLocalizer(self.name, slowmap),
            preprocessing_s=built - start - learning_s,
            mapping_s=learning_s + first_s,
            bytes=_file_bytes(slowmap),
            notes=tuple(log.hints),
        )


def _file_bytes(slowmap: SlowMap) -> int:
    """Of the file without the frames that a map remembers to learn from once more."""
    with tempfile.TemporaryDirectory(prefix="andante-") as folder:
        return replace(slowmap, memory=None).save(Path(folder) / "a.andante")
