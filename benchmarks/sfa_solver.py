"""One SFA problem in three libraries: seconds to fit, and the deltas as a check that all solved the same problem.

Each library needs an environment of its own, so this file runs in one at a time and prints JSON::

    python benchmarks/sfa_solver.py andante|mdp|sklearn-sfa

``benchmarks/speed.py --sfa`` makes the environments and runs all three.
"""

import json
import sys
import time

import numpy as np

PROBLEMS = ((5000, 230, 8), (20000, 230, 8), (20000, 900, 20))
REPEATS = 3


def series(n: int, d: int) -> np.ndarray:
    """Mixed sines of many speeds with noise; the same numbers from any numpy of this decade."""
    rng = np.random.RandomState(0)
    t = np.arange(n)[:, None] / n
    sources = np.sin(2 * np.pi * t * (1 + 3 * np.arange(d)[None, :] ** 1.2) + np.arange(d))
    return sources @ rng.standard_normal((d, d)) / np.sqrt(d) + 0.1 * rng.standard_normal((n, d))


def fit_andante(x: np.ndarray, k: int) -> np.ndarray:
    from andante.sfa import LinearSFA

    return LinearSFA(k).fit(x).transform(x)


def fit_mdp(x: np.ndarray, k: int) -> np.ndarray:
    import mdp

    node = mdp.nodes.SFANode(output_dim=k)
    node.train(x)
    return node.execute(x)


def fit_sklearn_sfa(x: np.ndarray, k: int) -> np.ndarray:
    from sksfa import SFA

    return SFA(n_components=k).fit_transform(x)


def main(library: str) -> None:
    fit = {"andante": fit_andante, "mdp": fit_mdp, "sklearn-sfa": fit_sklearn_sfa}[library]
    fit(series(500, 20), 4)  # imports are not what is compared
    rows = []
    for n, d, k in PROBLEMS:
        x, best = series(n, d), np.inf
        for _ in range(REPEATS):
            start = time.perf_counter()
            y = fit(x, k)
            best = min(best, time.perf_counter() - start)
        deltas = (np.diff(y, axis=0) ** 2).mean(axis=0) / y.var(axis=0)
        rows.append({"samples": n, "signals": d, "outputs": k, "seconds": best, "deltas": deltas.tolist()})
    json.dump(rows, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1])
