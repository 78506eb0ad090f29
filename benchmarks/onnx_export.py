"""Exported maps in onnxruntime beside ``SlowMap.localize``: size, time of one image, largest difference.

    python benchmarks/onnx_export.py [--data ../shared/data/garden_a] [--images 300]

Maps ``border_summer`` and localizes ``border_autumn`` of ``garden_a`` (rendered fisheye frames of 480 x 480). Both run
in this process, one image after the other, without decoding and without the views that a map imagines, which have no
form in ONNX; times are medians over all images. Needs the extra onnx.
"""

import argparse
import math
import os
import platform
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import onnxruntime
from threadpoolctl import threadpool_limits

from andante import MapConfig, SlowMap, build_map, export_onnx, open_recording
from andante.export.judgement import STATUSES

CONFIGS = {
    "default": MapConfig(),
    "default, polynomial": MapConfig().with_values({"readout": {"kind": "polynomial"}}),
    "default, gaussian-process": MapConfig().with_values({"readout": {"kind": "gaussian-process"}}),
    "pixels": MapConfig().with_values({"features": {"kind": "pixels"}}),
    "thesis": MapConfig.thesis(),
    "thesis, raw images": MapConfig.thesis_pixels(),
}


def session(path: Path, threads: int) -> onnxruntime.InferenceSession:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    return onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])


def milliseconds(function: Callable[[np.ndarray], object], images: list[np.ndarray]) -> float:
    spent = []
    for image in images:
        start = time.perf_counter()
        function(image)
        spent.append(time.perf_counter() - start)
    return 1e3 * statistics.median(spent)


def in_python(slowmap: SlowMap, images: list[np.ndarray], threads: int) -> float:
    cv2.setNumThreads(threads)
    with threadpool_limits(threads):
        return milliseconds(slowmap.localize, images)


def differences(
    slowmap: SlowMap, exported: onnxruntime.InferenceSession, images: list[np.ndarray]
) -> tuple[float, float, float, int]:
    """Largest difference of slow features, of positions and of headings, and how many statuses differ."""
    slow, position, heading, statuses = 0.0, 0.0, 0.0, 0
    names = [one.name for one in exported.get_outputs()]
    for image in images:
        found = dict(zip(names, exported.run(None, {"image": image}), strict=True))
        estimate = slowmap.localize(image)
        slow = max(slow, np.abs(found["slow"] - slowmap.slow_features(image)).max())
        statuses += STATUSES[found["status"].item()] != estimate.status
        if estimate.status.has_pose:
            position = max(position, np.hypot(*(found["xy"] - (estimate.x_m, estimate.y_m))))
        if estimate.heading_rad is not None:
            turn = math.remainder(found["heading_rad"].item() - estimate.heading_rad, 2 * math.pi)
            heading = max(heading, abs(math.degrees(turn)))
    return slow, position, heading, statuses


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--data", type=Path, default=Path("../shared/data/garden_a"))
    parser.add_argument("--images", type=int, default=300)
    arguments = parser.parse_args()
    summer, autumn = (open_recording(arguments.data / f"border_{name}") for name in ("summer", "autumn"))
    images = [autumn.load(info) for info in autumn.infos[: arguments.images]]
    print(f"onnxruntime {onnxruntime.__version__}, Python {platform.python_version()}, {os.cpu_count()} cores")
    print("| map | map file, ONNX file | onnxruntime, 1 / 2 threads | Python, 1 / 2 threads | largest difference |")
    print("|---|---|---|---|---|")
    for name, config in CONFIGS.items():
        slowmap = build_map([summer], config.with_values({"memory": {"keep": False}, "off_path": {"enabled": False}}))
        with tempfile.TemporaryDirectory() as folder:
            size, path = slowmap.save(Path(folder) / "m.andante"), Path(folder) / "m.onnx"
            exported = export_onnx(slowmap, path)
            sessions = [session(path, threads) for threads in (1, 2)]
        timed = [milliseconds(lambda image, s=one: s.run(None, {"image": image}), images) for one in sessions]
        python = [in_python(slowmap, images, threads) for threads in (1, 2)]
        slow, position, heading, statuses = differences(slowmap, sessions[0], images)
        print(
            f"| {name} | {size / 1e6:.2f}, {exported.bytes / 1e6:.2f} MB | {timed[0]:.2f} / {timed[1]:.2f} ms | "
            f"{python[0]:.2f} / {python[1]:.2f} ms | slow features {slow:.0e}, position {1e3 * position:.3f} mm, "
            f"heading {heading:.4f} degrees, {statuses} of {len(images)} statuses |"
        )


if __name__ == "__main__":
    main()
