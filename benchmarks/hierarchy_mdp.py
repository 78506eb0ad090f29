"""The hierarchical network of the thesis in MDP 3.6, the library behind it: seconds, deltas and outputs.

Runs in an environment of its own, which ``benchmarks/hierarchy.py`` makes, and prints JSON::

    mdp-env/bin/python -W ignore benchmarks/hierarchy_mdp.py JOB.json

JOB.json names ``pictures`` (a .npy file of (n, height, width)), the ``layers`` (field, stride, reduced_dim,
output_dim, clip), the ``deviation_floor``, a ``batch`` of pictures to train on at a time, and where to write
``outputs`` (.npy). The network is built as MDP means it to be: switchboards, one cloned node a layer. Each layer is
trained on the stored outputs of the one below, and the last picture of a batch comes again in the next one (thesis
5.1.1).
"""

import json
import sys
import time
from pathlib import Path

import mdp
import numpy as np

SINGLE_PICTURES = 20


class PatchNormalisation(mdp.Node):
    """Zero mean, and unit deviation but for a floor."""

    def __init__(self, floor: float, input_dim: int) -> None:
        super().__init__(input_dim=input_dim, output_dim=input_dim)
        self.floor = floor

    def is_trainable(self) -> bool:
        return False

    def is_invertible(self) -> bool:
        return False

    def _execute(self, x: np.ndarray) -> np.ndarray:
        x = x - x.mean(axis=1, keepdims=True)
        return x / np.sqrt((x * x).mean(axis=1, keepdims=True) + self.floor**2)


def layer_nodes(layer: dict, below: tuple[int, int, int], floor: float | None) -> tuple:
    """The switchboard and the cloned nodes of one layer on a map of (width, height, channels)."""
    width, height, channels = below
    switchboard = mdp.hinet.Rectangular2dSwitchboard(
        in_channels_xy=(width, height),
        field_channels_xy=tuple(layer["field"] or (width, height)),
        field_spacing_xy=tuple(layer["stride"]),
        in_channel_dim=channels,
    )
    dim = switchboard.out_channel_dim
    # Patches without a mean lack one direction, so that the first node has to cope with that.
    first = [] if floor is None else [PatchNormalisation(floor, dim)]
    reduce = mdp.nodes.SFANode(input_dim=dim, output_dim=layer["reduced_dim"], rank_deficit_method="pca")
    rest = [mdp.nodes.QuadraticExpansionNode(), mdp.nodes.SFANode(output_dim=layer["output_dim"])]
    clip = [] if layer["clip"] is None else [mdp.nodes.CutoffNode(-layer["clip"], layer["clip"])]
    node = mdp.hinet.FlowNode(mdp.Flow([*first, reduce, *rest, *clip]))
    return switchboard, mdp.hinet.CloneLayer(node, n_nodes=switchboard.output_channels)


def train(job: dict, x: np.ndarray, shape: tuple[int, int]) -> tuple[list, np.ndarray]:
    below, network = (shape[1], shape[0], 1), []
    for number, layer in enumerate(job["layers"]):
        switchboard, nodes = layer_nodes(layer, below, job["deviation_floor"] if number == 0 else None)
        starts = range(0, len(x) - 1, job["batch"])
        while nodes.is_training():
            for start in starts:
                chunk = switchboard(x[start : start + job["batch"] + 1].astype(float))
                nodes.train(chunk, include_last_sample=start == starts[-1])
            nodes.stop_training()
        x = np.concatenate(
            [nodes(switchboard(x[a : a + job["batch"]].astype(float))) for a in range(0, len(x), job["batch"])]
        )
        network += [switchboard, nodes]
        below = (*switchboard.out_channels_xy, layer["output_dim"])
    return network, x


def main(path: str) -> None:
    job = json.loads(Path(path).read_text())
    pictures = np.load(job["pictures"])
    x = pictures.reshape(len(pictures), -1)
    start = time.perf_counter()
    network, y = train(job, x, pictures.shape[1:])
    training = time.perf_counter() - start
    single = []
    for picture in x[:SINGLE_PICTURES]:
        start = time.perf_counter()
        signals = picture[None].astype(float)
        for node in network:
            signals = node(signals)
        single.append(time.perf_counter() - start)
    np.save(job["outputs"], y)
    deltas = (np.diff(y, axis=0) ** 2).mean(axis=0) / y.var(axis=0)
    result = {"train_s": training, "picture_ms": float(np.median(single)) * 1e3, "deltas": deltas.tolist()}
    json.dump(result, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1])
