"""The low-pass against the one of SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from sct_twin.signals.filters import low_pass


@pytest.mark.parametrize(
    ("count", "corner", "padding"), [(16, 100.0, 15), (5000, 10.0, 300), (700, 300.0, 0)]
)
def test_equals_the_filter_of_scipy(count: int, corner: float, padding: int) -> None:
    rng = np.random.default_rng(count)
    values = 300e3 + 1e3 * np.cumsum(rng.standard_normal(count))
    known = sosfiltfilt(butter(2, corner, fs=1000.0, output="sos"), values, padlen=padding)
    assert np.allclose(low_pass(values, 1e-3, corner, padding), known, rtol=1e-9, atol=1e-6)


def test_a_constant_stays() -> None:
    assert np.allclose(low_pass(np.full(200, 42.0), 1e-3, 20.0, 100), 42.0, rtol=1e-12)
