"""Deltas and outputs of a small hierarchical network in MDP 3.6, on pictures from a closed formula.

    mdp-env/bin/python -W ignore benchmarks/hierarchy_oracle.py > tests/sfa/data/hierarchy_oracle.json

See ``mdp_oracle.py`` for the environment. Grey at (x, y) of picture t is 120 plus the sum over k = 1..9 of
30 / sqrt(k) sin(k + 0.23 k x cos(k) + 0.19 k y sin(k) + 0.004 k^1.7 t): travelling waves, no random numbers.
"""

import json
import sys

import mdp
import numpy as np

from hierarchy_mdp import train

PICTURES, HEIGHT, WIDTH = 500, 10, 20
FLOOR = 5.0
ROWS = (0, 123, 250, 499)
LAYERS = (
    {"field": (4, 4), "stride": (2, 2), "reduced_dim": 6, "output_dim": 5, "clip": 4.0},
    {"field": (3, 2), "stride": (3, 2), "reduced_dim": 7, "output_dim": 6, "clip": 4.0},
    {"field": None, "stride": (1, 1), "reduced_dim": 8, "output_dim": 4, "clip": None},
)


def pictures() -> np.ndarray:
    t, y, x = np.arange(PICTURES)[:, None, None], np.arange(HEIGHT)[:, None], np.arange(WIDTH)
    waves = [
        30 / np.sqrt(k) * np.sin(k + 0.23 * k * x * np.cos(k) + 0.19 * k * y * np.sin(k) + 0.004 * k**1.7 * t)
        for k in range(1, 10)
    ]
    return 120 + sum(waves)


def main() -> None:
    grey = pictures()
    job = {"layers": LAYERS, "deviation_floor": FLOOR, "batch": 90}
    _, y = train(job, grey.reshape(PICTURES, -1), (HEIGHT, WIDTH))
    deltas = (np.diff(y, axis=0) ** 2).mean(axis=0) / y.var(axis=0)
    result = {
        "made_by": f"benchmarks/hierarchy_oracle.py with MDP {mdp.__version__}, numpy {np.__version__}",
        "pictures": (PICTURES, HEIGHT, WIDTH),
        "layers": LAYERS,
        "deviation_floor": FLOOR,
        "checksum": float(grey.sum()),
        "deltas": deltas.tolist(),
        "rows": ROWS,
        "outputs": ((y - y.mean(axis=0)) / y.std(axis=0))[list(ROWS)].tolist(),
    }
    json.dump(result, sys.stdout, indent=1)
    sys.stdout.write("\n")


if __name__ == "__main__":
    main()
