"""The network of the landmark detector, written down once for whoever runs it: torch to learn, ONNX to use.

About 0.3 million weights. Convolutions reach around the horizon, so that turning the robot by a whole number of
``COARSEST`` columns turns the result and changes nothing else. A coarse branch sees the surroundings, from which a
landmark is told from its like; the heat map is read at ``STRIDE`` pixels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

STRIDE = 8
COARSEST = 16
PER_LANDMARK = 5
"""Heat, two offsets, two sizes."""

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True)
class Convolution:
    """A square convolution with bias; ``plain`` ones end the network and are not normalised while learning."""

    inputs: int
    outputs: int
    kernel: int = 3
    stride: int = 1
    plain: bool = False


class Operations(Protocol[Value]):
    """What the network is made of, over values (n, channels, height, width)."""

    def convolved(self, name: str, value: Value) -> Value:
        """The convolution ``name`` with wrapped columns, zeros above and below."""
        ...

    def rectified(self, value: Value) -> Value:
        """Negative numbers as 0."""
        ...

    def added(self, first: Value, second: Value) -> Value:
        """Sums."""
        ...

    def doubled(self, value: Value) -> Value:
        """Every cell as two by two."""
        ...


def convolutions(landmarks: int) -> dict[str, Convolution]:
    """All convolutions by name for a number of landmarks."""
    found = {
        "stem": Convolution(3, 16, 5, 2),
        "half": Convolution(16, 32, 3, 2),
        "fine": Convolution(32, 48, 3, 2),
        "coarse": Convolution(48, 64, 3, 2),
        "merge": Convolution(64, 48, 1),
        "head": Convolution(48, 48),
        "told": Convolution(48, PER_LANDMARK * landmarks, 1, plain=True),
    }
    blocks = {"half": 32, "fine": 48, "coarse": 64, "wide": 64, "joint": 48}
    for name, channels in blocks.items():
        found |= {f"{name}.{part}": Convolution(channels, channels) for part in ("first", "second")}
    return found


def apply(operations: Operations[Value], value: Value) -> Value:
    """Normalised panoramas (n, 3, height, width) -> (n, 5 k, height / 8, width / 8)."""

    def layer(name: str, value: Value) -> Value:
        return operations.rectified(operations.convolved(name, value))

    def block(name: str, value: Value) -> Value:
        inner = operations.convolved(f"{name}.second", layer(f"{name}.first", value))
        return operations.rectified(operations.added(value, inner))

    value = block("half", layer("half", layer("stem", value)))
    fine = block("fine", layer("fine", value))
    coarse = block("wide", block("coarse", layer("coarse", fine)))
    raised = operations.doubled(operations.convolved("merge", coarse))
    joint = block("joint", operations.rectified(operations.added(fine, raised)))
    return operations.convolved("told", layer("head", joint))
