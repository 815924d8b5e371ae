"""Linear algebra on one thread."""

from __future__ import annotations

from threadpoolctl import threadpool_limits


def one_blas_thread() -> threadpool_limits:
    """A context in which the linear algebra of NumPy and SciPy uses one thread.

    Thousands of small matrices: threads would cost more than they give, many times more where the
    cores are busy. SciPy brings a BLAS of its own, which can be limited only once it is loaded.
    """
    import scipy.linalg  # noqa: F401

    return threadpool_limits(1, user_api="blas")
