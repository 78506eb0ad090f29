"""Which of all detections are the one anchor: chains of those that follow from each other, and the strongest chains.

Between frames a thing moves with the robot's turn, and a little with its way. What fits to no neighbour is an outlier.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray
from andante.errors import InputError
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.standing import stands_elsewhere

_LONGEST_GAP = 15
_SLACK_RAD = 0.06
_OF_WIDTH_A_FRAME = 0.35
_SIZE_A_FRAME = 0.3
_AROUND = 4  # frames before and after with which a size is compared
_UNSTEADY = 0.35  # of the logarithm of a size
_RIVAL_FRAMES = 5
_RIVAL_STRENGTH = 0.25
_ALONE = 2  # detections of a chain of which none else says anything


@dataclass(frozen=True, slots=True)
class Chosen:
    """Tells two anchors of a kind apart: the one that is nearest to an azimuth in a frame."""

    frame: int
    azimuth_rad: float


def one_anchor(
    detections: Mapping[int, Sequence[Detection]],
    turn_rad: FloatArray,
    chosen: Chosen | None = None,
    poses: FloatArray | None = None,
) -> dict[int, Detection]:
    """The detections of one thing by frame, at most one in each, outliers removed.

    ``turn_rad`` (n,) is how far the robot has turned counter-clockwise since frame 0, in the frame of ``detections``.
    Two things of a kind that are never seen in one frame are told apart by where they stand, where ``poses`` (n, 3)
    of the robot say so (x, y, heading, NaN where unknown), and else are taken for one. Raises ``InputError`` where
    there are two and nothing is ``chosen``, and where nothing is found near to what is.
    """
    chains = sorted(_chains(detections, turn_rad), key=lambda chain: -_strength(chain))
    if chosen is not None:
        chains = _led_by(chains, chosen)
    kept: dict[int, Detection] = {}
    for chain in chains:
        shared = kept.keys() & chain.keys()
        if not shared:
            if kept and poses is not None and stands_elsewhere(kept, chain, poses):
                if chosen is None and _strength(chain) >= _RIVAL_STRENGTH * _strength(kept):
                    raise InputError(_two_places(kept, chain))
            elif len(chain) >= _ALONE or not kept:
                kept |= chain
        elif chosen is None and len(shared) >= _RIVAL_FRAMES and _strength(chain) >= _RIVAL_STRENGTH * _strength(kept):
            raise InputError(_two_anchors(kept, chain, min(shared)))
    return _steady(dict(sorted(kept.items())))


def _steady(track: dict[int, Detection]) -> dict[int, Detection]:
    """Without boxes of other sizes than those of the frames around: a detector takes a part for the whole at times."""
    frames = np.array(list(track))
    sizes = np.log([(max(one.box.width_rad, 1e-3), max(one.box.height_rad, 1e-3)) for one in track.values()])
    steady: dict[int, Detection] = {}
    for at, (frame, detection) in enumerate(track.items()):
        around = sizes[np.abs(frames - frame) <= _AROUND]
        usual = np.median(around, axis=0)
        if len(around) < _AROUND or np.abs(sizes[at] - usual).max() <= _UNSTEADY:
            steady[frame] = detection
    return steady


def _strength(chain: Mapping[int, Detection]) -> float:
    return sum(detection.score for detection in chain.values())


def _led_by(chains: list[dict[int, Detection]], chosen: Chosen) -> list[dict[int, Detection]]:
    """The chain that was pointed at first."""
    near = [
        (abs(wrapped(chain[chosen.frame].box.azimuth_rad - chosen.azimuth_rad)), number)
        for number, chain in enumerate(chains)
        if chosen.frame in chain
    ]
    if not near:
        found = sorted({frame for chain in chains for frame in chain})
        told = f"it was in {len(found)} others, as {found[len(found) // 2]}" if found else "nor in any other"
        raise InputError(f"no such thing was found in frame {chosen.frame}, {told}; choose a frame in which it was")
    first = min(near)[1]
    return [chains[first], *chains[:first], *chains[first + 1 :]]


def _two_anchors(first: Mapping[int, Detection], second: Mapping[int, Detection], frame: int) -> str:
    name = first[frame].name
    degrees = [np.degrees(chain[frame].box.azimuth_rad) for chain in (first, second)]
    return (
        f"two things called {name!r} are in view, in frame {frame} at azimuths {degrees[0]:.0f} and {degrees[1]:.0f} "
        f"degrees; say which by a frame and an azimuth (--which {frame},{degrees[0]:.0f}), or take one of them away"
    )


def _two_places(first: Mapping[int, Detection], second: Mapping[int, Detection]) -> str:
    told = []
    for chain in (first, second):
        frame = sorted(chain)[len(chain) // 2]
        told.append((frame, float(np.degrees(chain[frame].box.azimuth_rad))))
    (frame, degrees), (other, others) = told
    return (
        f"two things called {next(iter(first.values())).name!r} stand in different places, one in frame {frame} at "
        f"azimuth {degrees:.0f} degrees and one in frame {other} at {others:.0f}; say which by a frame and an azimuth "
        f"(--which {frame},{degrees:.0f}), or take one of them away"
    )


def _chains(detections: Mapping[int, Sequence[Detection]], turn_rad: FloatArray) -> list[dict[int, Detection]]:
    """Detections linked over frames, those that fit best first; what fits to no chain begins one."""
    chains: list[dict[int, Detection]] = []
    for frame in sorted(detections):
        fits = []
        for number, chain in enumerate(chains):
            last = next(reversed(chain))
            turned = turn_rad[frame] - turn_rad[last]
            for which, detection in enumerate(detections[frame]):
                off = _misfit(chain[last].box, detection.box, frame - last, turned)
                if off <= 1.0 and frame - last <= _LONGEST_GAP:
                    fits.append((off, number, which))
        free, continued = set(range(len(detections[frame]))), set[int]()
        for _, number, which in sorted(fits):
            if which in free and number not in continued:
                chains[number][frame] = detections[frame][which]
                free.remove(which)
                continued.add(number)
        chains += [{frame: detections[frame][which]} for which in sorted(free)]
    return chains


def _misfit(before: Box, after: Box, frames: int, turned_rad: float) -> float:
    """How badly one box follows from another some frames earlier; up to 1 is what driving explains."""
    size = max(before.width_rad, after.width_rad)
    aside = abs(wrapped(after.azimuth_rad - before.azimuth_rad + turned_rad))
    tall = max(before.height_rad, after.height_rad)
    # What the lower end of the picture cuts off decides about sizes too, so these may differ more than places.
    growth = abs(float(np.log(max(after.width_rad, 1e-3) / max(before.width_rad, 1e-3))))
    return max(
        aside / (_SLACK_RAD + _OF_WIDTH_A_FRAME * size * min(frames, 4)),
        abs(after.elevation_rad - before.elevation_rad) / (_SLACK_RAD + _OF_WIDTH_A_FRAME * tall * min(frames, 4)),
        growth / (0.4 + _SIZE_A_FRAME * min(frames, 4)),
    )
