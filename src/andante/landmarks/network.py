"""The network of ``layout`` in torch, to be learnt. Imported only by what learns."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from andante.landmarks.detector_file import LEAST_CONTRAST, Folded
from andante.landmarks.heatmaps import Targets
from andante.landmarks.layout import PER_LANDMARK, Convolution, apply, convolutions

_RARE_HEAT = 0.02
"""Heat that an unlearnt network tells everywhere, so that it need not unlearn first that landmarks are everywhere."""


class LandmarkNetwork(nn.Module):
    """Panoramas (n, 3, height, width) of any scale -> (n, k, 5, rows, columns): heat as logits, then the shapes."""

    def __init__(self, landmarks: int) -> None:
        super().__init__()
        self.landmarks = landmarks
        self._plan = convolutions(landmarks)
        self.layers = nn.ModuleDict({_key(name): _layer(plan) for name, plan in self._plan.items()})
        told = self.layers[_key("told")]
        assert isinstance(told, nn.Sequential)
        with torch.no_grad():
            last = told[0]
            assert isinstance(last, nn.Conv2d)
            assert last.bias is not None
            last.weight.mul_(0.1)
            last.bias.zero_()
            last.bias[::PER_LANDMARK] = float(np.log(_RARE_HEAT / (1.0 - _RARE_HEAT)))

    def forward(self, panoramas: Tensor) -> Tensor:
        """Normalise, then what the layout says."""
        told = apply(self, normalised(panoramas))
        return told.reshape(len(told), self.landmarks, PER_LANDMARK, *told.shape[2:])

    def convolved(self, name: str, value: Tensor) -> Tensor:
        """A convolution with its normalisation, over wrapped columns."""
        margin = self._plan[name].kernel // 2
        wrapped = functional.pad(value, (margin, margin, 0, 0), mode="circular") if margin else value
        result: Tensor = self.layers[_key(name)](wrapped)
        return result

    def rectified(self, value: Tensor) -> Tensor:
        """Negative numbers as 0."""
        return functional.relu(value)

    def added(self, first: Tensor, second: Tensor) -> Tensor:
        """Sums."""
        return first + second

    def doubled(self, value: Tensor) -> Tensor:
        """Every cell as two by two."""
        return functional.interpolate(value, scale_factor=2.0, mode="nearest")

    def folded(self) -> dict[str, Folded]:
        """Its convolutions by name, with what it normalises by as part of them."""
        return {name: _folded(self.layers[_key(name)]) for name in self._plan}


def averaged_in(average: LandmarkNetwork, network: LandmarkNetwork, keep: float) -> None:
    """Move an exponential average of networks on by one: ``keep`` of the old, the rest of the new."""
    with torch.no_grad():
        new = network.state_dict()
        for name, values in average.state_dict().items():
            if values.is_floating_point():
                values.lerp_(new[name], 1.0 - keep)


def normalised(panoramas: Tensor) -> Tensor:
    """Panoramas (n, 3, height, width) of grey levels 0..255 with mean 0 and deviation 1 each."""
    centred = panoramas - panoramas.mean(dim=(1, 2, 3), keepdim=True)
    power = centred.square().mean(dim=(1, 2, 3), keepdim=True)
    return centred / power.sqrt().clamp(min=LEAST_CONTRAST)


def loss(told: Tensor, targets: Targets, counts: Tensor) -> Tensor:
    """CenterNet's focal loss of the heat and, where a landmark is, the absolute error of its shape.

    ``counts`` (n, k) is 0 for landmarks of which nothing is known in a panorama, else 1.
    """
    heat, shape, weight = (torch.from_numpy(part) for part in (targets.heat, targets.shape, targets.weight))
    logits = told[:, :, 0]
    log_hot, log_cold = functional.logsigmoid(logits), functional.logsigmoid(-logits)
    hot = (heat == 1.0).to(logits.dtype)
    missed = hot * log_hot * log_cold.exp().square()
    invented = (1.0 - hot) * (1.0 - heat) ** 4 * log_cold * log_hot.exp().square()
    there = (counts * hot.amax(dim=(2, 3))).sum().clamp(min=1.0)
    focal = -((missed + invented) * counts[:, :, None, None]).sum() / there
    weight = weight * counts[:, :, None, None]
    apart = ((told[:, :, 1:] - shape).abs().sum(dim=2) * weight).sum() / weight.sum().clamp(min=1.0)
    return focal + 0.5 * apart


def _key(name: str) -> str:
    return f"layer_{name.replace('.', '_')}"  # dots and names like "half" are torch's own


def _layer(plan: Convolution) -> nn.Sequential:
    layer = nn.Conv2d(
        plan.inputs, plan.outputs, plan.kernel, plan.stride, padding=(plan.kernel // 2, 0), bias=plan.plain
    )
    return nn.Sequential(layer) if plan.plain else nn.Sequential(layer, nn.BatchNorm2d(plan.outputs))


def _folded(layer: nn.Module) -> Folded:
    assert isinstance(layer, nn.Sequential)
    convolution = layer[0]
    assert isinstance(convolution, nn.Conv2d)
    weight = convolution.weight.detach().double()
    if len(layer) == 1:
        assert convolution.bias is not None
        return Folded(_array(weight), _array(convolution.bias.detach()))
    norm = layer[1]
    assert isinstance(norm, nn.BatchNorm2d)
    assert norm.running_mean is not None
    assert norm.running_var is not None
    factor = norm.weight.detach().double() / (norm.running_var.double() + norm.eps).sqrt()
    return Folded(
        _array(weight * factor[:, None, None, None]),
        _array(norm.bias.detach().double() - norm.running_mean.double() * factor),
    )


def _array(values: Tensor) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    return np.asarray(values.float().numpy(), np.float32)
