"""The hierarchical network beside MDP 3.6 on the same pictures: time, memory, and that both learn the same.

    python benchmarks/hierarchy.py [--data ../shared/data/garden_a] [--no-mdp] [--no-memory]

Needs the recordings border_summer, border_autumn, border_winter and infield_summer of ``garden_a`` (1,000 of their
rendered fisheye frames). Everything that is made is kept in ``.bench/``, the environment of MDP included. Both sides
run with the threads of the BLAS that they find; OMP_NUM_THREADS limits both.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from andante.camera import PanoramaGeometry, Unwrapper
from andante.features import FourierEncoder
from andante.mapping.compact import CompactModel
from andante.recordings import open_recording
from andante.sfa import (
    LANDMARK_LAYERS,
    PANORAMA_LAYERS,
    HierarchicalSFA,
    Layer,
    QuadraticModel,
    QuadraticSFA,
    one_thread,
    pca_of_samples,
)
from speed import SESSIONS, WORK, best, environment

FLOOR = 20.0
MDP_BATCH = 100
PCA_COMPONENTS = 300
LANDMARK_CORNER = (180, 20)
"""(row, column) of a 120 x 120 view of the border of the garden in the 480 x 480 frames."""


def prepared(data: Path) -> dict[str, Path]:
    """1,000 panoramas 600 x 60 and 1,000 views 120 x 120 of the same frames, as .npy files."""
    files = {name: WORK / f"hierarchy_{name}.npy" for name in ("panoramas", "landmarks")}
    if all(file.exists() for file in files.values()):
        return files
    print("preparing the pictures ...", file=sys.stderr)
    panoramas, landmarks = [], []
    row, column = LANDMARK_CORNER
    for name, length in SESSIONS:
        recording = open_recording(data / name)
        unwrap = None
        for frame in recording.frames(range(length)):
            unwrap = unwrap or Unwrapper(recording.camera, frame.image.shape, PanoramaGeometry())
            panoramas.append(unwrap(frame.image))
            landmarks.append(frame.image[row : row + 120, column : column + 120])
    np.save(files["panoramas"], np.stack(panoramas))
    np.save(files["landmarks"], np.stack(landmarks))
    return files


def picture_ms(function: Callable[[np.ndarray], object], pictures: np.ndarray) -> float:
    """The median over single calls."""
    spent = []
    for picture in pictures[:200]:
        start = time.perf_counter()
        function(picture)
        spent.append(time.perf_counter() - start)
    return statistics.median(spent) * 1e3


def mdp(python: Path, file: Path, layers: Sequence[Layer]) -> tuple[dict, np.ndarray]:
    """What MDP needs and finds."""
    job, outputs = WORK / "hierarchy_job.json", WORK / "hierarchy_mdp_outputs.npy"
    values = {
        "pictures": str(file),
        "layers": [asdict(layer) for layer in layers],
        "deviation_floor": FLOOR,
        "batch": MDP_BATCH,
        "outputs": str(outputs),
    }
    job.write_text(json.dumps(values))
    script = str(Path(__file__).parent / "hierarchy_mdp.py")
    run = subprocess.run([str(python), "-W", "ignore", script, str(job)], stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(run.stdout), np.load(outputs)


def agreement(network: HierarchicalSFA, pictures: np.ndarray, found: dict, outputs: np.ndarray) -> str:
    """How far deltas (relative) and outputs (in deviations, up to sign) are apart."""
    deltas = np.max(np.abs(network.deltas_ / found["deltas"] - 1))
    ours = np.concatenate([network.transform(part) for part in np.array_split(pictures, 10)])
    theirs = (outputs - outputs.mean(axis=0)) / outputs.std(axis=0)
    ours = (ours - ours.mean(axis=0)) / ours.std(axis=0)
    gap = np.abs(ours * np.sign((ours * theirs).sum(axis=0)) - theirs).max()
    return f"deltas apart by {deltas:.0e}, outputs by {gap:.0e}"


def compared(name: str, file: Path, layers: Sequence[Layer], python: Path | None) -> None:
    pictures = np.load(file)
    network = HierarchicalSFA(layers, deviation_floor=FLOOR)
    seconds = best(lambda: network.fit(pictures))
    single = picture_ms(network.transform, pictures)
    n, height, width = pictures.shape
    print(f"{name} {width}x{height}, {n} pictures: training {seconds:.2f} s, one picture {single:.2f} ms")
    print(f"  deltas {' '.join(f'{delta:.4f}' for delta in network.deltas_)}")
    many = best(lambda: network.transform(pictures))
    print(f"  a batch of all: {many / n * 1e3:.2f} ms a picture")
    if python is None:
        return
    # MDP's unit variance is that of n - 1, which shows where outputs are clipped: the last layer goes without.
    layers = [*layers[:-1], replace(layers[-1], clip=None)]
    found, outputs = mdp(python, file, layers)
    network = HierarchicalSFA(layers, deviation_floor=FLOOR).fit(pictures)
    exact = HierarchicalSFA(layers, deviation_floor=FLOOR, double=True)
    start = time.perf_counter()
    exact.fit(pictures)
    double = time.perf_counter() - start
    print(
        f"  MDP 3.6: training {found['train_s']:.1f} s ({found['train_s'] / seconds:.1f} x), one picture "
        f"{found['picture_ms']:.1f} ms ({found['picture_ms'] / single:.0f} x)"
    )
    print(f"  single precision: {agreement(network, pictures, found, outputs)}")
    print(f"  double precision ({double:.2f} s): {agreement(exact, pictures, found, outputs)}")


def fourier(file: Path) -> None:
    pictures = np.load(file)
    encoder = FourierEncoder(*pictures.shape[1:])

    def learn() -> QuadraticModel:
        features = np.concatenate([encoder.encode(part) for part in np.array_split(pictures, 20)])
        pca = pca_of_samples(features, PCA_COMPONENTS)
        return QuadraticSFA(8, reduced_dim=20).fit(pca.transform(features)).model_.after(pca)

    with one_thread():
        seconds, model = best(learn), CompactModel.of(learn())
        single = picture_ms(lambda picture: model.transform(encoder.encode(picture)[None]), pictures)
    print(f"Fourier features and one quadratic node: training {seconds:.2f} s, one picture {single:.2f} ms")


def peak_memory(file: Path, copies: int) -> float:
    """Peak resident size in MB of a process that learns from the pictures, so many times over, in batches of 50."""
    script = """
import resource, sys
import numpy as np
from andante.sfa import HierarchicalSFA

def batches():
    for lap in range(int(sys.argv[2])):
        with open(sys.argv[1], "rb") as file:
            version = np.lib.format.read_magic(file)
            (n, height, width), _, dtype = np.lib.format.read_array_header_1_0(file)
            for _ in range(0, n, 50):
                yield np.fromfile(file, dtype, 50 * height * width).reshape(-1, height, width)

HierarchicalSFA().fit(batches)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""
    run = subprocess.run(
        [sys.executable, "-c", script, str(file), str(copies)], stdout=subprocess.PIPE, text=True, check=True
    )
    return float(run.stdout)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data/garden_a"))
    parser.add_argument("--no-mdp", action="store_true", help="leave out MDP (which is installed into .bench/)")
    parser.add_argument("--no-memory", action="store_true", help="leave out the 10,000 pictures")
    options = parser.parse_args()
    WORK.mkdir(exist_ok=True)
    files = prepared(options.data)
    python = None
    if not options.no_mdp:
        python = environment(
            "mdp",
            ["setuptools<70", "wheel", "numpy==1.23.5", "scipy==1.10.1", "future"],
            ["--no-build-isolation", "mdp==3.6"],
        )
    print(f"{os.cpu_count()} processors, OMP_NUM_THREADS={os.environ.get('OMP_NUM_THREADS', 'unset')}")
    compared("table 5.1", files["panoramas"], PANORAMA_LAYERS, python)
    compared("table 5.2", files["landmarks"], LANDMARK_LAYERS, python)
    fourier(files["panoramas"])
    if not options.no_memory:
        few, many = peak_memory(files["panoramas"], 1), peak_memory(files["panoramas"], 10)
        print(f"peak memory: 1,000 pictures {few:.0f} MB, 10,000 pictures {many:.0f} MB")


if __name__ == "__main__":
    main()
