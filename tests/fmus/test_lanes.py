"""The mathematical functions of the kernels: distance from the exact value, special values, one equals many."""

from __future__ import annotations

import ctypes
import math
import re
import warnings
from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import numpy.typing as npt
import pytest

from tests.fmus import remez
from tests.fmus.compiled import BUILDS, NATIVE, compile_library, kernel_sources

Array = npt.NDArray[np.float64]
FUNCTIONS = ("exp", "log", "tanh", "sigmoid")
#: Stated in lanes_math.h, and what every function has to keep: 2.
STATED = {"exp": 0.9, "log": 0.9, "tanh": 1.5, "sigmoid": 1.8}
TINY = [5e-324, 1e-310, 2.2250738585072009e-308, 2.2250738585072014e-308, 1e-300, 1e-20]
INF, NAN = math.inf, math.nan


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    return compile_library(kernel_sources(), tmp_path_factory.mktemp("lanes"))


@pytest.fixture(params=["plain", "wide"])
def build(request: pytest.FixtureRequest, library: ctypes.CDLL) -> int:
    if request.param == "wide" and not library.has_wide():
        pytest.skip("this processor has no AVX2 + FMA")
    return BUILDS[request.param]


def many(library: ctypes.CDLL, name: str, x: Array, build: int) -> Array:
    values = np.array(x, dtype=np.float64)
    getattr(library, f"tf_{name}_many")(values.ctypes.data_as(ctypes.c_void_p), len(values), build)
    return values


def one(library: ctypes.CDLL, name: str, x: float, build: int) -> float:
    function = getattr(library, f"tf_{name}_one")
    function.restype = ctypes.c_double
    return float(function(ctypes.c_double(x), build))


def arguments(name: str) -> Array:
    """Return random arguments wherever a function does something, shape (n,)."""
    rng = np.random.default_rng(2)
    size = np.exp(rng.uniform(math.log(1e-320), math.log(1e3), 2000))
    near = rng.uniform(-2.0, 2.0, 4000)
    if name == "log":
        around = 1.0 + rng.uniform(-0.4, 0.6, 3000) * 10.0 ** -rng.uniform(0.0, 15.0, 3000)
        wide = np.exp(rng.uniform(-744.0, 709.0, 3000))
        roots = np.nextafter(np.sqrt(0.5) * 2.0 ** np.arange(-20, 20), [[0.0], [INF]]).ravel()
        return np.concatenate(
            [around, wide, roots, rng.uniform(0.4, 3.0, 3000), TINY, [1.7976931348623157e308]]
        )
    limit = 20.0 if name == "tanh" else 746.0
    halves = (np.arange(-40, 41) + 0.5) * math.log(2.0) / (2.0 if name == "tanh" else 1.0)
    ends = np.array([*TINY, 708.39, 708.4, 709.78, 709.782712893384, 710.0, 744.0, 745.1, 745.133, 746.0])
    parts = [size, near, rng.uniform(-limit, limit, 4000), halves, ends]
    return np.concatenate([*parts, *(-p for p in parts)])


def exact(name: str, x: float) -> Any:
    argument = mp.mpf(x)
    if name == "sigmoid":
        return 1 / (1 + mp.exp(-argument))
    function: Callable[[Any], Any] = getattr(mp, name)
    return function(argument)


def distance(value: float, reference: Any) -> float:
    """Return ``|value - reference|`` in units of the last place of the reference."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        rounded = float(reference)
    if math.isinf(rounded) or math.isinf(value):
        # The largest number may come out instead of an overflow, and the other way round.
        return 0.0 if rounded == value else 2.0 * (min(abs(rounded), abs(value)) < 1.797693134862315e308)
    return float(abs(mp.mpf(value) - reference) / mp.mpf(float(np.spacing(abs(rounded)))))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_value_is_within_two_units_of_the_last_place(
    name: str, library: ctypes.CDLL, build: int
) -> None:
    x = arguments(name)
    got = many(library, name, x, build)
    with mp.workdps(40):
        worst = max(distance(float(y), exact(name, float(a))) for a, y in zip(x, got, strict=True))
    assert worst <= STATED[name] <= 2.0


SPECIAL = {
    "exp": [(0.0, 1.0), (-0.0, 1.0), (INF, INF), (-INF, 0.0), (NAN, NAN), (710.0, INF), (1e308, INF), (-746.0, 0.0), (-1e308, 0.0), (5e-324, 1.0), (-1e-300, 1.0)],
    "log": [(1.0, 0.0), (0.0, -INF), (-0.0, -INF), (INF, INF), (-INF, NAN), (-1.0, NAN), (-5e-324, NAN), (NAN, NAN)],
    "tanh": [(0.0, 0.0), (-0.0, -0.0), (INF, 1.0), (-INF, -1.0), (NAN, NAN), (20.0, 1.0), (-1e308, -1.0), (5e-324, 5e-324), (-5e-324, -5e-324), (1e-310, 1e-310)],
    "sigmoid": [(0.0, 0.5), (-0.0, 0.5), (INF, 1.0), (-INF, 0.0), (NAN, NAN), (40.0, 1.0), (1e308, 1.0), (-1e308, 0.0), (5e-324, 0.5)],
}  # fmt: skip


@pytest.mark.parametrize("name", FUNCTIONS)
def test_special_values_are_those_of_the_c_library(name: str, library: ctypes.CDLL, build: int) -> None:
    x, expected = np.array(SPECIAL[name]).T
    for got in (many(library, name, x, build), np.array([one(library, name, float(a), build) for a in x])):
        np.testing.assert_array_equal(got, expected)
        assert np.array_equal(np.signbit(got)[~np.isnan(expected)], np.signbit(expected)[~np.isnan(expected)])
    if name != "sigmoid":
        with np.errstate(all="ignore"):
            np.testing.assert_array_equal(expected, getattr(np, name)(x))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_number_has_the_same_bits_alone_and_in_a_vector(
    name: str, library: ctypes.CDLL, build: int
) -> None:
    x = arguments(name)[::7]
    together = many(library, name, x, build)
    assert np.array_equal(together, [one(library, name, float(a), build) for a in x])
    for count in range(1, 20):
        assert np.array_equal(many(library, name, x[:count], build), together[:count])


def test_coefficients_are_those_of_the_algorithm() -> None:
    text = (NATIVE / "lanes_math.h").read_text(encoding="utf-8")
    for function, coefficients in (("exp_parts", remez.exponential()), ("log_body", remez.logarithm())):
        body = text[text.index(f"double tf_{function}(") :]
        written = {float.fromhex(h) for h in re.findall(r"0x1\.[0-9a-f]+p-?\d+", body[: body.index("\n}\n")])}
        written.add(0.5)
        assert set(coefficients) <= written
