"""Eigenvalues of symmetric matrices.

eigen   values in rising order, and vectors
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def eigen(matrix: Floats) -> tuple[Floats, Floats]:
    """Values (k,) and vectors (k, k) of a symmetric matrix. LAPACK's divide and conquer, which is
    the quickest, gives up on some that are singular but for rounding; its relatively robust
    representations do not (Dhillon and Parlett 2004)."""
    try:
        values, vectors = np.linalg.eigh(matrix)
    except np.linalg.LinAlgError:
        from scipy.linalg import eigh

        values, vectors = eigh(matrix, driver="evr")
    return values, vectors
