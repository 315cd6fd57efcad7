"""One thread for linear algebra: with small matrices more threads only wait for each other."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")


def one_blas_thread(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """Return the function as it is called with one thread of BLAS; its types stay those of the function.

    Examples
    --------
    >>> one_blas_thread(max)(1.0, 2.0)
    2.0
    """
    limited: Callable[_Parameters, _Result] = threadpool_limits.wrap(limits=1, user_api="blas")(function)
    return limited
