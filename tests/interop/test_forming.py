"""A forming process coupled with friction runs in the clients as it runs here."""

from __future__ import annotations

import numpy as np
import pytest

from .forming import Extrusion
from .running import version
from .subjects import Subjects

#: Relative difference of forces that the solver does not resolve.
SOLVER = 1e-5


@pytest.fixture(scope="module")
def extrusion(subjects: Subjects, tmp_path_factory: pytest.TempPathFactory) -> Extrusion:
    return Extrusion.made(subjects, tmp_path_factory.mktemp("extrusion"))


@pytest.fixture(scope="module")
def force(extrusion: Extrusion) -> np.ndarray:
    return extrusion.ours()


@pytest.mark.nightly  # by day the next test, and what libcosim does with the slider of `test_masters`
def test_libcosim(extrusion: Extrusion, force: np.ndarray) -> None:
    if not version("libcosimpy"):
        pytest.skip("not installed: libcosimpy (extra [interop])")
    assert force[-1] > 10.0
    # Steps counted in nanoseconds differ in the last bit, and a remeshing amplifies that; another
    # order of coupling gives another force.
    np.testing.assert_allclose(extrusion.theirs("libcosim"), force, rtol=SOLVER)
    assert np.max(np.abs(extrusion.ours("gauss_seidel") - force)) > 5.0 * SOLVER * force[-1]


def test_a_host_without_python(extrusion: Extrusion, force: np.ndarray) -> None:
    if not (version("ecospy") and version("tbb")):
        pytest.skip("not installed: ecospy and tbb (extra [interop])")
    np.testing.assert_allclose(extrusion.theirs("ecos"), force, rtol=SOLVER, atol=1e-6)
