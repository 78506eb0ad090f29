"""Time, memory and safety of a map that grows: ten drives of 800 frames, one update, crashes and poison.

    python benchmarks/living.py DRIVE... [--side 480]

``DRIVE`` are recorded or rendered sessions of one garden (``andante experiment long-term`` renders ten). Each is made
into one of 800 frames: pictures are repeated with noise of their own and a few centimetres apart, at ``--side`` pixels.
What it makes is kept in ``.bench/``.
"""

import argparse
import itertools
import json
import os
import resource
import shutil
import subprocess
import sys
import time
import zlib
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from andante.data import Frame, FrameInfo, Pose2D
from andante.errors import AndanteError
from andante.mapping import BuildLog, SlowMap, build_map, update_map
from andante.mapping.history import digest_of, roll_back
from andante.recordings import MemoryRecording, iterate_frames, open_recording, write_recording

WORK = Path(".bench")
FRAMES = 800
KILLS = 20


def repeated(folder: Path, side: int) -> Iterator[Frame]:
    recording = open_recording(folder)
    rng = np.random.default_rng(zlib.crc32(recording.name.encode()))
    # One field of noise, moved for every picture: drawing it anew would take longer than all else.
    noise = rng.normal(0, 2, (side, side, 3)).astype(np.float32)
    count = 0
    for lap in itertools.count():
        for frame in recording.frames(colour=True):
            if count == FRAMES:
                return
            image = cv2.resize(frame.image, (side, side), interpolation=cv2.INTER_CUBIC)
            own = np.roll(noise, tuple(rng.integers(0, side, 2)), axis=(0, 1))
            noisy = np.clip(image + own, 0, 255).astype(np.uint8)
            pose = frame.info.reference
            moved = Pose2D(pose.x_m + 0.03 * lap, pose.y_m, pose.heading_rad)
            yield Frame(FrameInfo(count, f"images/{count:06d}.jpg", 0.2 * count, None, moved), noisy)
            count += 1


def prepared(folder: Path, side: int) -> Path:
    target = WORK / f"year_{side}" / folder.name
    if not target.exists():
        print(f"preparing {target} ...", file=sys.stderr)
        source = open_recording(folder)
        height = source.load(source.infos[0]).shape[0]
        scale, camera = side / height, source.camera
        if camera.centre_px is not None and camera.radius_px is not None:
            centre = tuple((c + 0.5) * scale - 0.5 for c in camera.centre_px)
            camera = type(camera)(centre_px=centre, radius_px=camera.radius_px * scale)
        target.parent.mkdir(parents=True, exist_ok=True)
        conditions = {"season": source.conditions.get("season", "unknown")}
        write_recording(target, repeated(folder, side), name=folder.name, camera=camera, conditions=conditions)
    return target


def child(task: str, *arguments: str) -> dict[str, float]:
    """A task of this file in a process of its own, so that its peak of memory is its own."""
    out = subprocess.run(
        [sys.executable, __file__, "--task", task, *arguments], capture_output=True, text=True, check=True
    )
    return dict(json.loads(out.stdout))


def task(name: str, arguments: list[str]) -> dict[str, float]:
    log, start = BuildLog(), time.perf_counter()
    if name == "map":
        *folders, path = arguments
        size = build_map([open_recording(one) for one in folders], log=log).save(path)
    else:
        source, folder, path = arguments
        slowmap, _ = update_map(SlowMap.load(source, with_memory=True), open_recording(folder), log=log)
        size = slowmap.save(path)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {**log.seconds, "total": time.perf_counter() - start, "peak_mb": peak, "bytes": size}


def timed(folders: list[Path]) -> None:
    start = time.perf_counter()
    for folder in folders:
        for _ in iterate_frames(open_recording(folder)):
            pass
    decode = time.perf_counter() - start
    names = [str(folder) for folder in folders]
    whole, part, grown = (str(WORK / f"{name}.andante") for name in ("whole", "part", "grown"))
    mapped = child("map", *names, whole)
    child("map", *names[:-1], part)
    updated = child("update", part, names[-1], grown)
    localize_only = SlowMap.load(whole).save(WORK / "small.andante")
    frames = FRAMES * len(folders)
    print(f"decode {frames} frames alone: {decode:.1f} s")
    for what, one in ((f"map {frames} frames", mapped), (f"update by {FRAMES} frames", updated)):
        stages = ", ".join(f"{stage} {one[stage]:.1f}" for stage in ("decode", "features", "learn", "readout"))
        print(f"{what}: {one['total']:.1f} s ({stages}), peak {one['peak_mb']:.0f} MB, map {one['bytes'] / 1e6:.2f} MB")
    print(f"mapping / decoding alone: {mapped['total'] / decode:.2f}")
    print(f"localize-only map of the same: {localize_only / 1e6:.2f} MB")
    print(f"update gives the bytes of mapping all at once: {Path(whole).read_bytes() == Path(grown).read_bytes()}")


def killed(folders: list[Path]) -> None:
    """``andante update`` of a small map, killed at random moments of its run, again and again."""
    path, first = WORK / "killed.andante", WORK / "first.andante"
    build_map([open_recording(folders[0])]).save(first)
    shutil.rmtree(f"{path}.history", ignore_errors=True)
    shutil.copy(first, path)
    command = [str(Path(sys.executable).parent / "andante"), "update", str(path), str(folders[1])]
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    took, new = time.perf_counter() - start, path.read_bytes()
    rng, left = np.random.default_rng(0), []
    for number in range(KILLS):
        shutil.copy(first, path)
        # Half of the moments within the last tenth, where files are written.
        moment = rng.uniform(0, took) if number % 2 else rng.uniform(0.9, 1.1) * took
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(moment)
        process.kill()
        process.wait()
        SlowMap.load(path, with_memory=True)
        left.append("old" if path.read_bytes() == first.read_bytes() else "new" if path.read_bytes() == new else "?")
    counts = ", ".join(f"{left.count(what)} x {what}" for what in ("old", "new", "?"))
    print(f"killed {KILLS} times, a whole map each time: {counts}")
    before = first.read_bytes()
    shutil.copy(first, path)
    subprocess.run(command, check=True, capture_output=True)
    roll_back(path)
    print(f"rollback restores the bytes: {path.read_bytes() == before} ({digest_of(path)})")


def poisoned(folders: list[Path], foreign: Path | None) -> None:
    slowmap = build_map([open_recording(folder) for folder in folders[:3]])
    good = open_recording(folders[3])
    pictures = [good.load(info) for info in good.infos]
    poses = np.array([(i.reference.x_m, i.reference.y_m, i.reference.heading_rad) for i in good.infos])
    rng = np.random.default_rng(0)
    partly = poses.copy()
    partly[500:] = rng.permutation(partly[500:])
    dock = poses[:1] + rng.normal(0, 0.02, poses.shape)
    forged = {
        "shuffled poses": (pictures, rng.permutation(poses)),
        "a third of the poses shuffled": (pictures, partly),
        "drift of 3 m": (pictures, poses + np.linspace(0, 1, len(poses))[:, None] * [3, 0, 0]),
        "shifted by 0.5 m": (pictures, poses + np.array([0.5, 0, 0])),
        "docked, poses tremble by 2 cm": ([p.copy() for p in pictures[:1] * len(pictures)], dock),
        "wheels turn, camera hangs": (pictures[:1] * len(pictures), poses),
    }
    cases = {"the good drive": good}
    for what, (images, table) in forged.items():
        reference = [Pose2D(*row) for row in table.tolist()]
        times = [info.timestamp_s for info in good.infos]
        cases[what] = MemoryRecording(images, times, good.camera, reference=reference, name=what)
    if foreign is not None:
        cases["another garden"] = open_recording(foreign)
    for what, recording in cases.items():
        try:
            _, trial = update_map(slowmap, recording)
            print(f"{what}: added, {trial.agreeing:.0%} agree")
        except AndanteError as error:
            print(f"{what}: refused: {error}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("drives", type=Path, nargs="*")
    parser.add_argument("--side", type=int, default=480)
    parser.add_argument("--foreign", type=Path, help="a drive of another garden")
    parser.add_argument("--task", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.task:
        print(json.dumps(task(options.task, [str(one) for one in options.drives])))
        return
    WORK.mkdir(exist_ok=True)
    print(f"{os.cpu_count()} processors")
    folders = [prepared(folder, options.side) for folder in options.drives]
    timed(folders)
    killed(folders)
    poisoned(folders, options.foreign)


if __name__ == "__main__":
    main()
