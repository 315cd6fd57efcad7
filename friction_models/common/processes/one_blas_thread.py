"""One thread for linear algebra: with small matrices more gain nothing, and lose much when cores are shared."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import scipy.linalg.lapack  # noqa: F401  (the library must be loaded before its threads can be limited)
from threadpoolctl import ThreadpoolController


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Run BLAS and LAPACK on one thread, in a block or in a function; the results then depend on no setting.

    Examples
    --------
    >>> with one_blas_thread():
    ...     max(1.0, 2.0)
    2.0
    >>> @one_blas_thread()
    ... def larger(a, b):
    ...     return max(a, b)
    >>> larger(1.0, 2.0)
    2.0
    """
    with _controller().limit(limits=1, user_api="blas"):
        yield
