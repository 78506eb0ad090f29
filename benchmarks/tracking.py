"""Time of a frame beyond decoding, and memory over many frames.

    python benchmarks/tracking.py MAP RECORDING [--frames 100000]

Takes any map and any recording with odometry that it has not seen. Pictures are decoded and seen once; the filters then
fuse that evidence again and again, lap after lap, with an odometry and times that go on. One thread, and one for the
BLAS. Resident memory is told when the first thousand frames are done, in between, and at the end; a filter that keeps
nothing stays where it was.
"""

import argparse
import gc
import itertools
import statistics
import time
from dataclasses import replace
from pathlib import Path

from andante.evaluation.experiments.rides import Ride, composed
from andante.localization import make_tracker
from andante.mapping import SlowMap
from andante.recordings import open_recording
from andante.sfa import one_thread

WARM_UP = 1000


def resident_mb() -> float:
    """Of this process, as Linux tells it."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def timed(function, *arguments):
    start = time.perf_counter()
    result = function(*arguments)
    return result, 1e3 * (time.perf_counter() - start)


def percentiles(times_ms: list[float]) -> str:
    p99 = statistics.quantiles(times_ms, n=100)[98]
    return f"median {statistics.median(times_ms):.2f} ms, 99 % {p99:.2f} ms, longest {max(times_ms):.1f} ms"


def endless(ride: Ride):
    """Infos and evidence lap after lap, made one by one so that nothing is kept."""
    infos, steps = ride.infos, ride.steps()
    wait_s = statistics.median(b.timestamp_s - a.timestamp_s for a, b in itertools.pairwise(infos))
    pose, time_s = infos[0].odometry, 0.0
    for number in itertools.count():
        at = number % len(ride)
        if number:
            pose = composed(steps[[at, at]], pose)[1]
            time_s += wait_s
        yield ride.evidence[at], replace(infos[at], index=number, timestamp_s=time_s, odometry=pose)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", type=Path)
    parser.add_argument("recording", type=Path)
    parser.add_argument("--frames", type=int, default=100_000)
    options = parser.parse_args()
    recording = open_recording(options.recording)
    slowmap = SlowMap.load(options.map).for_recording(recording)
    with one_thread():
        evidence, seeing, eye = [], [], make_tracker(slowmap)
        for frame in recording.frames():
            seen, spent = timed(eye.see, frame.image)
            evidence.append(seen)
            seeing.append(spent)
        heading = "with" if any(one.estimate.heading_rad is not None for one in evidence) else "without"
        print(f"single image {heading} heading: {percentiles(seeing)}")
        ride = Ride(tuple(recording.infos), tuple(evidence))
        for kind in ("kalman", "particles"):
            fuse(slowmap, ride, kind, options.frames)


def fuse(slowmap: SlowMap, ride: Ride, kind: str, frames: int) -> None:
    tracker, times = make_tracker(slowmap, kind), []
    memory = []
    for number, (seen, info) in zip(range(frames), endless(ride), strict=False):
        _, spent = timed(tracker.fuse, seen, info)
        if len(times) < WARM_UP or number % (frames // WARM_UP or 1) == 0:  # few are kept, or they would be what grows
            times.append(spent)
        if number == WARM_UP or (number > WARM_UP and number % (frames // 20 or 1) == 0):
            gc.collect()
            memory.append(resident_mb())
    gc.collect()
    memory.append(resident_mb())
    start, end, peak = memory[0], memory[-1], max(memory)
    print(f"{kind}: {percentiles(times)} a frame in the filter")
    print(f"{kind}: {frames} frames, resident {start:.1f} MB at first, {end:.1f} MB at the end, at most {peak:.1f} MB")


if __name__ == "__main__":
    main()
