"""What slow features leave unsaid, kept for the layers above (HiGSFA: Escalante-B. and Wiskott 2020).

Slow features of a small receptive field drop much that would have been slow in a larger one. Some of the outputs of a
node may therefore be principal components of its input less what the slow ones tell of it. They are linear in the same
signals as the slow ones, so that a model with them is one affine model like any other.
"""

from __future__ import annotations

import numpy as np

from andante.data import FloatArray
from andante.errors import LearningError
from andante.sfa.eigen import largest, sign_of_columns
from andante.sfa.model import AffineModel
from andante.sfa.moments import Moments


def with_residual(slow: AffineModel, moments: Moments, count: int, signals: int) -> AffineModel:
    """``slow``, learnt from ``moments``, and ``count`` outputs that carry on the rest of the first ``signals``.

    The rest is x - A y with the least squares prediction A from the slow outputs y. Its components come strongest
    first, with unit variance, uncorrelated with y and with each other. Raises ``LearningError`` where less is left.
    """
    if count == 0:
        return slow
    covariance, told = moments.covariance, slow.weights
    prediction = np.linalg.solve(told.T @ covariance @ told, told.T @ covariance[:, :signals])
    rest = covariance[:signals, :signals] - covariance[:signals] @ told @ prediction
    variance, directions = largest((rest + rest.T) / 2, count)
    if variance[-1] <= slow.rank_tolerance * covariance.diagonal()[:signals].max():
        raise LearningError(
            f"cannot carry on {count} components: {slow.output_dim} slow features tell nearly all of {signals} "
            "signals; ask for a smaller residual or fewer outputs"
        )
    weights: FloatArray = -told @ prediction @ directions
    weights[:signals] += directions
    weights *= sign_of_columns(weights) / np.sqrt(variance)
    deltas = np.einsum("ij,ij->j", weights, moments.edge_covariance @ weights)
    return AffineModel(
        slow.mean,
        np.hstack([slow.weights, weights]),
        np.concatenate([slow.deltas, deltas]),
        slow.rank,
        slow.rank_tolerance,
    )
