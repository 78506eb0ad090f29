"""Slow feature analysis for any time series: what changes least while everything changes.

Two ways in. An estimator, as in scikit-learn::

    features = LinearSFA(n_components=4).fit(series).transform(series)

or the two steps it consists of, for data that comes in pieces, from several machines, or along a graph of edges instead
of time::

    moments = Moments.of(x, edges).merge(more)
    pca     = PCA.of(moments, 200)
    model   = solve_slow(pca.project(moments), 20, ridge=1e-2).after(pca)
    model.transform(x)                                                     # (n, d) -> (n, 20)

Frames that are grouped by place instead of joined one by one have a closed form, which also forgets: ``PlaceMoments``.

Whole pictures go through a network of small nodes, layer by layer (thesis 5.1.1)::

    network = HierarchicalSFA(PANORAMA_LAYERS).fit(panoramas)              # (n, 60, 600), or streams of such batches
    network.transform(panorama)                                            # (60, 600) -> (8,)

Estimators learn; models (``AffineModel``, ``QuadraticModel``, ``HierarchicalModel``) are frozen, only transform, and
turn into named arrays for a file. Nothing here knows of cameras, poses or image files.
"""

from andante.sfa.expansion import expand_quadratic, expanded_dim, term_names
from andante.sfa.hierarchical import HierarchicalSFA
from andante.sfa.hierarchy import HierarchicalModel
from andante.sfa.kernel import KernelModel, KernelSFA
from andante.sfa.layers import LANDMARK_LAYERS, PANORAMA_LAYERS, Layer, grids_of
from andante.sfa.linear import LinearSFA
from andante.sfa.model import AffineModel, SlowModel
from andante.sfa.moments import Moments
from andante.sfa.pca import PCA, pca_of_samples
from andante.sfa.place_moments import PlaceMoments
from andante.sfa.quadratic import QuadraticModel, QuadraticSFA
from andante.sfa.solver import solve_slow
from andante.sfa.threads import one_thread

__all__ = [
    "LANDMARK_LAYERS",
    "PANORAMA_LAYERS",
    "PCA",
    "AffineModel",
    "HierarchicalModel",
    "HierarchicalSFA",
    "KernelModel",
    "KernelSFA",
    "Layer",
    "LinearSFA",
    "Moments",
    "PlaceMoments",
    "QuadraticModel",
    "QuadraticSFA",
    "SlowModel",
    "expand_quadratic",
    "expanded_dim",
    "grids_of",
    "one_thread",
    "pca_of_samples",
    "solve_slow",
    "term_names",
]
