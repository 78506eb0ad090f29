"""The particle filter behind the tracker."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, Hypothesis
from andante.errors import ArrayError
from andante.localization.clusters import Cluster, clusters_of, weighted_radius
from andante.localization.config import ParticleConfig
from andante.localization.filters import UNKNOWN_HEADING_RAD2, Gauss, Weighted
from andante.localization.judge import Belief
from andante.localization.motion import Step
from andante.localization.particles import Cloud
from andante.localization.trail import Trail

_CORE_SHARE = 0.35


class ParticleFilter:
    """Particles and the clusters they form."""

    def __init__(self, config: ParticleConfig, rng: np.random.Generator) -> None:
        self._config, self._rng = config, rng
        self._cloud: Cloud | None = None
        self._clusters: list[Cluster] = []
        self._moved_m = 0.0

    @property
    def best(self) -> Gauss | None:
        """The place that is believed in most; ``None`` while empty."""
        return Gauss(self._clusters[0].mean, self._clusters[0].covariance) if self._clusters else None

    @property
    def belief(self) -> Belief | None:
        """What decides how far it is believed."""
        if self._cloud is None:
            return None
        cloud, best = self._cloud, self._clusters[0]
        centre = best.mean[:2]
        radius = core = weighted_radius(cloud.state[:, :2], cloud.weight, centre)
        if best.share > _CORE_SHARE:  # else it is no cluster but a fragment
            core = weighted_radius(cloud.state[best.member, :2], cloud.weight[best.member], centre)
        return Belief(radius, core, best.share, self._moved_m, self._rivals())

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """All places, best first."""
        total = sum(one.share for one in self._clusters)
        return tuple(
            Hypothesis(
                float(one.mean[0]),
                float(one.mean[1]),
                one.share / total,
                float(one.mean[2]) if one.covariance[2, 2] < UNKNOWN_HEADING_RAD2 else None,
            )
            for one in self._clusters
        )

    def move(self, step: Step) -> None:
        """Follow odometry."""
        if self._cloud is not None:
            cloud = self._cloud.moved(step, self._config.motion, self._rng)
            if cloud is not self._cloud:
                self._take(cloud)

    def correct(self, seen: list[Weighted], trail: Trail, *, doubt: float) -> None:
        """Take in what was seen; see ``Filter``."""
        if self._cloud is None and seen:
            self._take(Cloud.around(seen[0].sighting, trail, self._config, self._rng))
            return
        if self._cloud is None:
            return
        cloud, before = self._cloud, self._clusters[0].mean[:2]
        for one in seen:
            cloud = cloud.weighed(one.likelihood(cloud.pose))
        mass = self._config.injected_weight * doubt**2
        for one in seen:
            if one.contradicts:
                cloud = cloud.injected(one.sighting, trail, mass, self._config, self._rng)
        self._take(cloud.resampled(self._config, self._rng))
        self._moved_m = float(np.hypot(*(self._clusters[0].mean[:2] - before)))

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Its state, for a file."""
        if self._cloud is None:
            return {}
        return {"state": self._cloud.state, "weight": self._cloud.weight}

    @property
    def generator_state(self) -> dict[str, Any]:
        """That of its generator."""
        return dict(self._rng.bit_generator.state)

    def resume(self, arrays: Mapping[str, FloatArray], generator: dict[str, Any] | None) -> None:
        """The inverse of both; raises ``ValueError``, ``KeyError`` or ``TypeError`` for what does not fit."""
        if generator is None:
            raise KeyError("generator")
        self._rng.bit_generator.state = generator
        if not arrays:
            return
        n = self._config.particles
        if set(arrays) != {"state", "weight"} or arrays["state"].shape != (n, 5) or arrays["weight"].shape != (n,):
            raise ArrayError(f"a state of {n} particles has arrays state ({n}, 5) and weight ({n},)")
        if (arrays["weight"] < 0).any() or abs(arrays["weight"].sum() - 1) > 1e-6:
            raise ArrayError("the weights of particles are positive and sum to one")
        self._take(Cloud(arrays["state"], arrays["weight"]))

    def _take(self, cloud: Cloud) -> None:
        self._cloud = cloud
        self._clusters = clusters_of(cloud.pose, cloud.weight, self._config.cluster_m)
        self._moved_m = 0.0

    def _rivals(self) -> str:
        return ", ".join(f"{one.share:.0%} for ({one.mean[0]:.1f}, {one.mean[1]:.1f})" for one in self._clusters[1:3])
