"""One BLAS thread: the band solver gains nothing from more, and loses much when cores are shared."""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cache
from typing import Any

import scipy.linalg.lapack  # noqa: F401  (the library must be loaded before its threads can be limited)
from threadpoolctl import ThreadpoolController


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


def one_blas_thread() -> AbstractContextManager[Any]:
    """Return a context in which BLAS and LAPACK run on one thread; the results then depend on no setting."""
    return _controller().limit(limits=1, user_api="blas")
