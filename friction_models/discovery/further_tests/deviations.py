"""Smooth curves along loads, in the existing tests and in tests beyond their range."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...estimation.campaign.binned_tests import BinnedTests
from ...loads import LOAD_NAMES, FloatArray, TriboLoads
from .protocols import PlannedTest

#: Distance over which a curve bends, as a share of the tested range of its load.
BEND = 0.25


class Deviations:
    """Gaussian processes along single loads, as columns whose coefficients have variance one.

    Unlike splines they do not run away beyond the tested range; there they are as uncertain as they were before any test. They
    are asked for on the further `tests`, too.
    """

    def __init__(self, campaign: BinnedTests, tests: Sequence[PlannedTest]) -> None:
        self.campaign = campaign
        self.fastest = max(float(campaign.loads.v_rel.max()), 1e-12)
        self._span: dict[str, tuple[float, float]] = {}
        self._knots: dict[str, FloatArray] = {}
        self._root: dict[str, FloatArray] = {}
        for name in LOAD_NAMES:
            values = self._scaled(name, campaign.distance if name == "sd" else getattr(campaign.loads, name))
            low, high = float(values.min()), float(values.max())
            self._span[name] = (low, max(high - low, 1e-12))
            z = np.concatenate([[0.0, 1.0], *(self._place(name, t.loads) for t in tests)])
            z = np.clip(z, -2.0, 3.0)
            count = int(np.ceil((z.max() - z.min()) / BEND)) + 1
            self._knots[name] = np.linspace(z.min(), z.max(), count)
            kernel = _kernel(self._knots[name], self._knots[name])
            self._root[name] = np.linalg.inv(np.linalg.cholesky(kernel + 1e-6 * np.eye(count))).T
        self._old: dict[str, FloatArray] = {}

    def old(self, names: Sequence[str]) -> FloatArray:
        """Return the curves along some loads in the bins of the existing tests, shape (m, k)."""
        for name in names:
            if name not in self._old:
                campaign = self.campaign
                values = campaign.average(
                    campaign.distance if name == "sd" else getattr(campaign.loads, name)
                )
                self._old[name] = self._columns(name, self._unit(name, values))
        return np.column_stack([np.empty((len(self.campaign.starts), 0)), *(self._old[n] for n in names)])

    def new(self, names: Sequence[str], loads: TriboLoads) -> FloatArray:
        """Return the same along a further test, shape (POINTS, k)."""
        return np.column_stack(
            [np.empty((len(loads), 0)), *(self._columns(n, self._place(n, loads)) for n in names)]
        )

    def _columns(self, name: str, z: FloatArray) -> FloatArray:
        return np.asarray(_kernel(z, self._knots[name]) @ self._root[name])

    def _place(self, name: str, loads: TriboLoads) -> FloatArray:
        return self._unit(name, getattr(loads, name))

    def _unit(self, name: str, values: FloatArray) -> FloatArray:
        low, width = self._span[name]
        return (self._scaled(name, values) - low) / width

    def _scaled(self, name: str, values: FloatArray) -> FloatArray:
        """Return values of a load on the scale on which its curves bend evenly."""
        if name == "v_rel":
            return np.log(values + 0.02 * self.fastest)
        if name == "sd":
            return np.sqrt(np.maximum(values, 0.0))
        if name in {"sigma_n", "psi"}:
            return np.log(np.maximum(values, 1e-6))
        return np.asarray(values, dtype=np.float64)


def _kernel(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.exp(-0.5 * ((a[:, None] - b) / BEND) ** 2)
