"""Delta values and outputs of MDP 3.6, the library behind the thesis, on data from closed formulas.

MDP does not import on numpy 2, so this runs in its own environment::

    python3 -m venv mdp-env
    mdp-env/bin/pip install "setuptools<70" wheel numpy==1.23.5 scipy==1.10.1 future
    mdp-env/bin/pip install --no-build-isolation mdp==3.6
    mdp-env/bin/python -W ignore benchmarks/mdp_oracle.py > tests/sfa/data/mdp_oracle.json

Signal j at sample t is sin(f t + j) + 0.5 sin(g t) + 0.3 sin(h t), with f = 0.011 (j + 1), g = 0.37 + 0.113 j,
h = 0.0007 (j + 1) t: slow waves, fast waves and chirps. No random numbers, so any numpy version gives the same series.
"""

import json
from itertools import pairwise

import mdp
import numpy as np

SAMPLES, SIGNALS, REDUCED, FEATURES = 1500, 10, 5, 4
EPISODES = (0, 700, 1500)
ROWS = (0, 99, 700, 1499)


def series() -> np.ndarray:
    t = np.arange(SAMPLES, dtype=float)[:, None]
    j = np.arange(SIGNALS, dtype=float)[None, :]
    slow = np.sin(0.011 * (j + 1) * t + j)
    fast = 0.5 * np.sin((0.37 + 0.113 * j) * t)
    chirp = 0.3 * np.sin(0.0007 * (j + 1) * t * t)
    return slow + fast + chirp


def deltas_by_definition(y: np.ndarray, episodes: tuple[int, ...]) -> list[float]:
    """Mean squared difference along time over the variance, both normalised by their own number of terms."""
    dy = np.concatenate([np.diff(y[start:stop], axis=0) for start, stop in pairwise(episodes)])
    return (np.mean(dy**2, axis=0) / np.var(y, axis=0)).tolist()


def unit(y: np.ndarray) -> np.ndarray:
    """Zero mean and unit variance over all samples; MDP normalises by n - 1."""
    return (y - y.mean(axis=0)) / y.std(axis=0)


def linear(x: np.ndarray, episodes: tuple[int, ...]) -> dict[str, object]:
    node = mdp.nodes.SFANode(output_dim=FEATURES)
    for start, stop in pairwise(episodes):
        node.train(x[start:stop])
    node.stop_training()
    y = node.execute(x)
    return {"deltas": deltas_by_definition(y, episodes), "outputs": unit(y)[list(ROWS)].tolist()}


def quadratic(x: np.ndarray) -> dict[str, object]:
    flow = mdp.Flow(
        [
            mdp.nodes.SFANode(output_dim=REDUCED),
            mdp.nodes.QuadraticExpansionNode(),
            mdp.nodes.SFANode(output_dim=FEATURES),
        ]
    )
    flow.train(x)
    y = flow.execute(x)
    return {"deltas": deltas_by_definition(y, (0, SAMPLES)), "outputs": unit(y)[list(ROWS)].tolist()}


def main() -> None:
    x = series()
    result = {
        "made_by": f"benchmarks/mdp_oracle.py with MDP {mdp.__version__}, numpy {np.__version__}",
        "samples": SAMPLES,
        "signals": SIGNALS,
        "reduced": REDUCED,
        "rows": ROWS,
        "episodes": EPISODES,
        "checksum": float(np.abs(x).sum()),
        "linear": linear(x, (0, SAMPLES)),
        "linear_episodes": linear(x, EPISODES),
        "quadratic": quadratic(x),
    }
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
