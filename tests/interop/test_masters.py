"""Our `jacobi` mode is what libcosim and ecos do; `gauss_seidel` has one step of lag less."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from .masters import difference, ours, seen_by_ecos, theirs
from .running import version
from .subjects import Subjects


@pytest.fixture(scope="module")
def jacobi(subjects: Subjects, tmp_path_factory: pytest.TempPathFactory) -> np.ndarray:
    return ours(subjects, "jacobi", tmp_path_factory.mktemp("jacobi") / "run")


def test_jacobi_is_what_libcosim_does(subjects: Subjects, jacobi: np.ndarray, tmp_path: Path) -> None:
    if not version("libcosimpy"):
        pytest.skip("not installed: libcosimpy (extra [interop])")
    assert difference(jacobi, theirs(subjects, "libcosim", tmp_path)) < 1e-9


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_jacobi_is_what_ecos_does(subjects: Subjects, jacobi: np.ndarray, tmp_path: Path, fmi: str) -> None:
    if not (version("ecospy") and version("tbb")):
        pytest.skip("not installed: ecospy and tbb (extra [interop])")
    found = theirs(subjects, "ecos_python", tmp_path, fmi)
    assert difference(seen_by_ecos(jacobi), found[:, :4]) < 1e-9


def test_friction_of_either_version_gives_the_same_run(
    subjects: Subjects, jacobi: np.ndarray, tmp_path: Path
) -> None:
    np.testing.assert_array_equal(ours(subjects, "jacobi", tmp_path / "run", "3.0"), jacobi)


def test_gauss_seidel_uses_the_newest_mu(subjects: Subjects, jacobi: np.ndarray, tmp_path: Path) -> None:
    lag = {mode: ours(subjects, mode, tmp_path / mode) for mode in ("gauss_seidel", "iterated")}
    # friction first: the slider advances with the mu of this step, in jacobi with that of the step before
    np.testing.assert_array_equal(lag["gauss_seidel"][:, 3], lag["gauss_seidel"][:, 4])
    np.testing.assert_array_equal(jacobi[1:, 3], jacobi[:-1, 4])
    error = {
        mode: difference(values, lag["iterated"])
        for mode, values in (("one", lag["gauss_seidel"]), ("two", jacobi))
    }
    assert 1e-6 < error["one"] < error["two"], "each step of lag costs something"
