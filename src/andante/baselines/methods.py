"""Every compared method by name; libraries are only imported for those that are asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

from andante.baselines.maps import MapMethod
from andante.baselines.method import Method
from andante.baselines.on_features import gaussian_process, nearest, ridge
from andante.baselines.thumbnails import ThumbnailMethod
from andante.errors import InputError, MissingExtraError
from andante.mapping import MapConfig

ANDANTE = "andante"


@dataclass(frozen=True, slots=True)
class MethodOptions:
    """What the methods that need it are told: ``weights`` of a network as a local ONNX file, a ``seed``.

    ``quick`` cuts the budgets of methods that learn for minutes, at the price of accuracy: for trying things out.
    """

    weights: Path | None = None
    seed: int = 0
    quick: bool = False


@dataclass(frozen=True, slots=True)
class KnownMethod:
    """A method by name, what it is in a few words, and the ``package`` that it needs from an ``extra``."""

    name: str
    what: str
    make: Callable[[MethodOptions], Method] = field(repr=False)
    package: str | None = None
    extra: str | None = None
    needs_weights: bool = False

    @property
    def lacks(self) -> MissingExtraError | None:
        """The library that is not there, with its install line."""
        if self.package is None or self.extra is None or find_spec(self.package) is not None:
            return None
        return MissingExtraError(self.package, self.extra)


def _andante(options: MethodOptions) -> Method:
    return MapMethod(ANDANTE, MapConfig(seed=options.seed))


def _thesis(options: MethodOptions) -> Method:
    # The thesis knows mapped places alone.
    config = MapConfig.thesis().with_values({"seed": options.seed, "off_path": {"enabled": False}})
    return MapMethod("thesis", config)


def _structure(view: Literal["fisheye", "pinhole"]) -> Callable[[MethodOptions], Method]:
    def make(options: MethodOptions) -> Method:
        from andante.baselines.structure import Sift, Structure

        return Structure(view, sift=Sift(most=2048)) if options.quick else Structure(view)

    return make


def _posenet(options: MethodOptions) -> Method:
    from andante.baselines.posenet import PoseNet, Schedule

    quick = Schedule(steps=600, max_seconds=120.0, validate_every=20, seed=options.seed)
    return PoseNet(schedule=quick if options.quick else Schedule(seed=options.seed))


def _embedding(options: MethodOptions) -> Method:
    from andante.baselines.embedding import Embedding

    if options.weights is None or not options.weights.is_file():
        raise InputError(f"--weights {options.weights} is no file; give the ONNX file of a network")
    return Embedding(options.weights)


METHODS: tuple[KnownMethod, ...] = (
    KnownMethod(ANDANTE, "a map of slow features with the package's defaults", _andante),
    KnownMethod("thesis", "a map of slow features with the thesis' choices", _thesis),
    KnownMethod("nearest-1", "the nearest mapped image by our features", lambda options: nearest(1)),
    KnownMethod("nearest-5", "the five nearest mapped images by our features", lambda options: nearest(5)),
    KnownMethod("thumbnails", "the nearest thumbnails under every turn", lambda options: ThumbnailMethod()),
    KnownMethod("ridge", "ridge regression from our features", lambda options: ridge()),
    KnownMethod("gaussian-process", "a Gaussian process from our features", lambda options: gaussian_process()),
    KnownMethod(
        "embedding",
        "the nearest mapped images by a network that the user brings (--weights)",
        _embedding,
        *("onnxruntime", "onnx"),
        needs_weights=True,
    ),
    KnownMethod("posenet", "a network trained on the spot to tell the pose", _posenet, "torch", "torch"),
    KnownMethod(
        "structure-fisheye",
        "structure from motion with SIFT on whole images, and perspective-n-point",
        _structure("fisheye"),
        *("pycolmap", "structure"),
    ),
    KnownMethod(
        "structure-pinhole",
        "the same on views of 90 degrees, as in the thesis",
        _structure("pinhole"),
        *("pycolmap", "structure"),
    ),
)
"""In the order of tables, the package's own first."""


def known_methods() -> str:
    """All names, for messages and help."""
    return ", ".join(one.name for one in METHODS)


def make_methods(names: Sequence[str], options: MethodOptions | None = None) -> list[Method]:
    """Methods by name, in this order, each once.

    Raises ``InputError`` for an unknown name or where weights are needed, ``MissingExtraError`` for a missing library.
    """
    options, by_name = options or MethodOptions(), {one.name: one for one in METHODS}
    chosen = []
    for name in dict.fromkeys(names):
        if name not in by_name:
            raise InputError(f"there is no method {name!r}; choose from {known_methods()}")
        known = by_name[name]
        if (missing := known.lacks) is not None:
            raise missing
        if known.needs_weights and options.weights is None:
            raise InputError(f"method {name!r} needs the ONNX file of a network; give it with --weights FILE")
        chosen.append(known.make(options))
    return chosen


def default_methods(options: MethodOptions | None = None) -> tuple[list[Method], tuple[str, ...]]:
    """All methods that can be made here, and a line for each that was left out: why, and what to do about it."""
    options, chosen, left_out = options or MethodOptions(), list[Method](), list[str]()
    for known in METHODS:
        if (missing := known.lacks) is not None:
            left_out.append(f"{known.name} is left out: {missing}")
        elif known.needs_weights and options.weights is None:
            left_out.append(f"{known.name} is left out: it needs the ONNX file of a network, given with --weights FILE")
        else:
            chosen.append(known.make(options))
    return chosen, tuple(left_out)
