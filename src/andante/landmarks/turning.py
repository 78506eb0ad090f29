"""How far a robot turned between two pictures, seen in how far its panorama shifted."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.data import ImageArray

_ROWS, _COLUMNS = 24, 720
_KEPT = 120  # frequencies a row: finer detail moves with the robot's way, not with its turn

Spectrum = NDArray[np.complex64]


def horizon_spectrum(panorama: ImageArray) -> Spectrum:
    """Panorama grey (H, W) or BGR (H, W, 3) -> (24, 120) spectra of its rows, each of about equal strength."""
    grey = panorama if panorama.ndim == 2 else cv2.cvtColor(panorama, cv2.COLOR_BGR2GRAY)
    small = cv2.resize(grey, (_COLUMNS, _ROWS), interpolation=cv2.INTER_AREA).astype(np.float32)
    spectrum = np.fft.rfft(small, axis=1)[:, 1 : _KEPT + 1]
    # Half-way to phases alone: strong low frequencies, as of light, do not decide by themselves.
    strength = np.sqrt(np.abs(spectrum)) + 1e-6
    return np.asarray(spectrum / strength, np.complex64)


def turn_between(before: Spectrum, after: Spectrum) -> float:
    """Radians in [-pi, pi) by which the robot turned counter-clockwise, to half a degree."""
    cross = np.zeros(_COLUMNS // 2 + 1, np.complex128)
    cross[1 : _KEPT + 1] = (after * before.conj()).sum(axis=0)
    shift = int(np.argmax(np.fft.irfft(cross, _COLUMNS)))
    return wrapped(2.0 * np.pi * shift / _COLUMNS)
