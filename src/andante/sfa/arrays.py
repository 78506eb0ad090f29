"""What every entry of this room asks of an array.

Learning runs on matrices of samples: one row a moment in time, one column a signal. The checks live here so
that all entries raise the same errors with the same words; ``ArrayError`` is a ``ValueError`` too, and the
words contain what scikit-learn's ``check_estimator`` looks for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from andante.errors import ArrayError

Matrix = NDArray[np.floating[Any]]
"""(n, d) samples in rows; float32 stays float32 and is widened block by block where it is summed."""


def as_matrix(x: ArrayLike) -> Matrix:
    """An (n, d) floating view or copy of ``x`` with n, d >= 1 and finite entries; raises ``ArrayError``."""
    if sp.issparse(x):
        raise ArrayError("sparse input is not supported: hand in a dense array, e.g. X.toarray()")
    array = np.asarray(x)
    if np.iscomplexobj(array):
        raise ArrayError("Complex data not supported: hand in real and imaginary parts as separate columns")
    if not np.issubdtype(array.dtype, np.floating):
        try:
            array = array.astype(np.float64)
        except ValueError as error:
            raise ArrayError(f"samples have to be numbers: {error}") from error
    if array.ndim != 2:
        raise ArrayError(
            f"expected samples as a 2D array (n_samples, n_features), got shape {array.shape}. "
            "Reshape your data: x.reshape(-1, 1) for one signal, x.reshape(1, -1) for one sample"
        )
    if 0 in array.shape:
        missing = "sample(s)" if len(array) == 0 else "feature(s)"
        raise ArrayError(f"Found array with 0 {missing} (shape={array.shape}) while a minimum of 1 is required.")
    require_finite(array)
    return array


def require_finite(array: Matrix) -> None:
    """Raise ``ArrayError`` that names the first row with NaN or infinity."""
    # A sum is finite only if all terms are; it needs no temporary array of the size of the data.
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(array.sum(dtype=np.float64)):
            return
    bad_rows = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad_rows):
        raise ArrayError(
            f"Input contains NaN or infinity in {len(bad_rows)} of {len(array)} rows, first in row {bad_rows[0]}: "
            "drop these rows and start a new episode behind each gap"
        )


def require_columns(array: Matrix, expected: int, who: str) -> None:
    """Raise ``ArrayError`` unless ``array`` (n, d) has ``expected`` columns; ``who`` is named in the message."""
    if array.ndim != 2 or array.shape[1] != expected:
        got = f"{array.shape[1]} features" if array.ndim == 2 else f"shape {array.shape}"
        raise ArrayError(f"X has {got}, but {who} is expecting {expected} features as input")


def require_names(arrays: Mapping[str, NDArray[Any]], names: Iterable[str], who: str) -> None:
    """Raise ``ArrayError`` that lists which of ``names`` are missing from the stored ``arrays`` of ``who``."""
    if missing := [name for name in names if name not in arrays]:
        found = ", ".join(sorted(arrays)) or "none"
        raise ArrayError(f"{who} lacks the stored arrays {', '.join(missing)}; found {found}")
