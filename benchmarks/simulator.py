"""Images a second and peak memory of the simulator.

    python benchmarks/simulator.py [--frames 40] [--workers 1 2]

Renders a few frames of one drive for each kind of picture, in a fresh process for each row, so that memory does not add
up. Making the scene (geometry, baked light) is told apart from rendering; memory is that of the largest process.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from andante.simulator import Plan, Session, SimulatedCamera, SimulatedRecording, render_plan

CAMERAS = {
    "fisheye 480x480": SimulatedCamera(),
    "panorama 600x60": SimulatedCamera(model="panorama", width_px=600, height_px=60, min_deg=5.0, max_deg=50.0),
    "panorama 1200x200": SimulatedCamera(model="panorama", width_px=1200, height_px=200, min_deg=-20.0, max_deg=40.0),
}


def plan(camera: str, frames: int) -> Plan:
    drive = {"kind": "infield", "frames": frames}
    return Plan(camera=CAMERAS[camera], sessions=(Session(name="drive", seed=1, drive=drive),))


def measure(camera: str, frames: int, workers: int) -> None:
    """One row, in this process: the clock starts with the first finished frame, when all scenes are about made."""
    if workers == 1:
        start = time.perf_counter()
        SimulatedRecording(plan(camera, 1), "drive").rendering(0)
        first_s = time.perf_counter() - start
    else:
        first_s = None
    ends, spent = [], []

    def progress(*_: object) -> None:
        ends.append(time.perf_counter())
        spent.append(time.process_time())

    with tempfile.TemporaryDirectory() as folder:
        render_plan(plan(camera, frames), Path(folder) / "out", workers=workers, progress=progress)
    # The first frames of many workers arrive together: count from the last of those.
    rate = (len(ends) - 4 * workers) / (ends[-1] - ends[4 * workers - 1])
    # Processor time does not depend on what else the machine does; that of other processes is not known here.
    cpu_ms = 1000 * (spent[-1] - spent[3]) / (len(spent) - 4) if workers == 1 else None
    used = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) / 1024
    print(json.dumps({"images_per_second": rate, "first_s": first_s, "cpu_ms": cpu_ms, "megabytes": used}))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--measure", nargs=3, metavar=("CAMERA", "FRAMES", "WORKERS"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        camera, frames, workers = options.measure
        measure(camera, int(frames), int(workers))
        return
    load = os.getloadavg()[0]
    print(f"{os.cpu_count()} processors, load {load:.1f} before\n")
    print("| picture | workers | images/s | CPU ms/image | first picture, s | MB, largest process |")
    print("|---|---|---|---|---|---|")
    for camera in CAMERAS:
        for workers in options.workers:
            call = [sys.executable, __file__, "--measure", camera, str(options.frames), str(workers)]
            row = json.loads(subprocess.run(call, capture_output=True, text=True, check=True).stdout)
            first = "" if row["first_s"] is None else f"{row['first_s']:.1f}"
            cpu = "" if row["cpu_ms"] is None else f"{row['cpu_ms']:.0f}"
            rate, size = f"{row['images_per_second']:.1f}", f"{row['megabytes']:.0f}"
            print(f"| {camera} | {workers} | {rate} | {cpu} | {first} | {size} |", flush=True)


if __name__ == "__main__":
    main()
