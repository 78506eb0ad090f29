"""Time and memory of everything a user waits for, as ratios to merely decoding the same images.

    python benchmarks/speed.py [--data ../shared/data/garden_a] [--sfa]

Needs the recordings border_summer, border_autumn, border_winter and infield_summer of ``garden_a`` (1,400 rendered
fisheye frames). Makes 1,000 of them into a recording of 480 x 480 JPEGs, enlarges them to 1440 x 1440, and repeats them
to 10,000 frames; what it makes is kept in ``.bench/``. Machines are noisy: every figure is the best of three
runs, and decoding is timed in the same run with the same threads.
"""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2

from andante.data import Frame, FrameInfo, Pose2D
from andante.mapping import BuildLog, SlowMap, build_map
from andante.recordings import iterate_frames, open_recording, write_recording

WORK = Path(".bench")
SESSIONS = (("border_summer", 300), ("border_autumn", 300), ("border_winter", 300), ("infield_summer", 100))
REPEATS = 3


def frames(data: Path, side: int, copies: int) -> Iterator[Frame]:
    """1,000 frames times ``copies``, enlarged to ``side``; copies stand a little apart, as another lap would."""
    count = 0
    for lap in range(copies):
        for name, length in SESSIONS:
            recording = open_recording(data / name)
            for frame in recording.frames(range(length), colour=True):
                pose = frame.info.reference
                moved = Pose2D(pose.x_m + 0.02 * lap, pose.y_m, pose.heading_rad)
                image = frame.image
                if image.shape[0] != side:
                    image = cv2.resize(image, (side, side), interpolation=cv2.INTER_CUBIC)
                yield Frame(FrameInfo(count, f"images/{count:06d}.jpg", 0.2 * count, None, moved), image)
                count += 1


def prepared(data: Path, side: int, copies: int = 1) -> Path:
    folder = WORK / f"garden_{side}_{copies}000"
    if not folder.exists():
        print(f"preparing {folder} ...", file=sys.stderr)
        camera = open_recording(data / SESSIONS[0][0]).camera
        scale = side / 480
        centre = tuple((c + 0.5) * scale - 0.5 for c in camera.centre_px)
        camera = type(camera)(centre_px=centre, radius_px=camera.radius_px * scale)
        write_recording(folder, frames(data, side, copies), name=folder.name, camera=camera)
    return folder


def best(function: Callable[[], object]) -> float:
    spent = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        function()
        spent.append(time.perf_counter() - start)
    return min(spent)


def mapping(folder: Path) -> SlowMap:
    recording = open_recording(folder)
    decode = best(lambda: [None for _ in iterate_frames(recording)])
    runs = []
    for _ in range(REPEATS):
        log, start = BuildLog(), time.perf_counter()
        slowmap = build_map([recording], log=log)
        runs.append((time.perf_counter() - start, log))
    total, log = min(runs, key=lambda run: run[0])
    stages = ", ".join(f"{stage} {seconds:.2f}" for stage, seconds in log.seconds.items())
    print(f"map {folder.name}: {total:.2f} s ({stages}); decode alone {decode:.2f} s; ratio {total / decode:.2f}")
    return slowmap


def localizing(slowmap: SlowMap, folder: Path) -> None:
    """One image at a time in one thread, from the file to the estimate."""
    recording = open_recording(folder)
    decode, whole = [], []
    for info in recording.infos[:300]:
        start = time.perf_counter()
        recording.load(info)
        middle = time.perf_counter()
        slowmap.localize(recording.load(info))
        decode.append(middle - start)
        whole.append(time.perf_counter() - middle)
    a, b = statistics.median(decode) * 1e3, statistics.median(whole) * 1e3
    print(f"localize {folder.name}: {b:.2f} ms an image, decoding alone {a:.2f} ms; ratio {b / a:.2f}")


def peak_memory(folder: Path) -> tuple[float, int]:
    """Peak resident size of a process that maps a folder, in MB, and the size of its map in bytes."""
    script = (
        "import resource, sys; from andante.mapping import build_map; from andante.recordings import open_recording;"
        "m = build_map([open_recording(sys.argv[1])]); size = m.save(sys.argv[2]);"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, size)"
    )
    out = subprocess.run(
        [sys.executable, "-c", script, str(folder), str(WORK / "memory.andante")],
        capture_output=True, text=True, check=True,
    ).stdout.split()  # fmt: skip
    return float(out[0]), int(out[1])


def starting() -> None:
    def run(*arguments: str) -> float:
        return best(lambda: subprocess.run(arguments, check=True, capture_output=True))

    bare = run(sys.executable, "-c", "pass")
    names = "import andante; andante.SlowMap, andante.build_map"
    print(
        f"python alone {bare:.2f} s; import andante {run(sys.executable, '-c', 'import andante') - bare:.2f} s more; "
        f"with all of mapping {run(sys.executable, '-c', names) - bare:.2f} s more; "
        f"andante --help {run(str(Path(sys.executable).parent / 'andante'), '--help'):.2f} s"
    )


def environment(name: str, *steps: list[str]) -> Path:
    folder = WORK / name
    if not (folder / "ready").exists():
        print(f"preparing the environment of {name} ...", file=sys.stderr)
        shutil.rmtree(folder, ignore_errors=True)
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        for packages in steps:
            subprocess.run([str(folder / "bin/pip"), "install", "-q", *packages], check=True)
        (folder / "ready").touch()
    return folder / "bin/python"


def solvers() -> None:
    mdp = environment(
        "mdp",
        ["setuptools<70", "wheel", "numpy==1.23.5", "scipy==1.10.1", "future"],
        ["--no-build-isolation", "mdp==3.6"],
    )
    pythons = {"andante": Path(sys.executable), "mdp": mdp, "sklearn-sfa": environment("sklearn-sfa", ["sklearn-sfa"])}
    script = str(Path(__file__).parent / "sfa_solver.py")
    results = {}
    for library, python in pythons.items():
        run = subprocess.run([str(python), "-W", "ignore", script, library], capture_output=True, text=True, check=True)
        results[library] = json.loads(run.stdout)
    for i, own in enumerate(results["andante"]):
        sizes = f"SFA {own['samples']} x {own['signals']} -> {own['outputs']}: andante {own['seconds']:.3f} s"
        for library in ("mdp", "sklearn-sfa"):
            other = results[library][i]
            apart = max(abs(a - b) / b for a, b in zip(own["deltas"], other["deltas"], strict=True))
            ratio = other["seconds"] / own["seconds"]
            sizes += f"; {library} {other['seconds']:.3f} s ({ratio:.1f} x, deltas apart by {apart:.0e})"
        print(sizes)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data/garden_a"))
    parser.add_argument("--sfa", action="store_true", help="also compare with MDP and sklearn-sfa (installs them)")
    parser.add_argument("--no-memory", action="store_true", help="leave out the 10,000 frames")
    options = parser.parse_args()
    WORK.mkdir(exist_ok=True)
    print(f"{os.cpu_count()} processors, best of {REPEATS} runs")
    for side in (480, 1440):
        folder = prepared(options.data, side)
        localizing(mapping(folder), folder)
    if not options.no_memory:
        few, few_bytes = peak_memory(prepared(options.data, 480))
        many, many_bytes = peak_memory(prepared(options.data, 480, 10))
        print(
            f"peak memory: 1,000 frames {few:.0f} MB (map {few_bytes / 1e6:.1f} MB), "
            f"10,000 frames {many:.0f} MB (map {many_bytes / 1e6:.1f} MB)"
        )
    starting()
    if options.sfa:
        solvers()


if __name__ == "__main__":
    main()
