"""How much of the time goes into reading and decoding images."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from andante.data import CameraSpec, Frame, FrameInfo, ImageArray
from andante.protocols import Recording, SkipCallback


class TimedRecording:
    """Another recording, with the seconds that all threads together spend in ``load`` counted."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._lock = threading.Lock()
        self.load_seconds = 0.0

    @property
    def name(self) -> str:
        """The name of the recording."""
        return self._recording.name

    @property
    def camera(self) -> CameraSpec:
        """Its camera."""
        return self._recording.camera

    @property
    def conditions(self) -> Mapping[str, Any]:
        """Its conditions."""
        return self._recording.conditions

    @property
    def infos(self) -> Sequence[FrameInfo]:
        """What is known of its frames."""
        return self._recording.infos

    def load(self, info: FrameInfo, *, colour: bool = False) -> ImageArray:
        """Read one frame's picture and count the time."""
        start = time.perf_counter()
        try:
            return self._recording.load(info, colour=colour)
        finally:
            spent = time.perf_counter() - start
            with self._lock:
                self.load_seconds += spent

    def frames(
        self, indices: Sequence[int] | None = None, *, colour: bool = False, on_skip: SkipCallback | None = None
    ) -> Iterator[Frame]:
        """The frames of the recording, not counted."""
        return self._recording.frames(indices, colour=colour, on_skip=on_skip)

    def content_hash(self) -> str:
        """The hash of the recording."""
        return self._recording.content_hash()
