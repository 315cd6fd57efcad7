"""Error measures of the paper: AE, ARE, their mean and spread over levels, with propagated uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


def percent(value: float, std: float) -> str:
    """Return a share and its uncertainty in percent.

    Examples
    --------
    >>> percent(0.123, 0.01)
    '12.3 +- 1.0 %'
    """
    return f"{100 * value:.1f} +- {100 * std:.1f} %"


@dataclass(frozen=True)
class Measured:
    """A measured quantity: mean over the repeats and their sample standard deviation (0 for a single one).

    Examples
    --------
    >>> Measured.of([99.0, 100.0, 101.0])
    Measured(mean=100.0, std=1.0, repeats=3)
    """

    mean: float
    std: float
    repeats: int

    @classmethod
    def of(cls, values: Sequence[float] | np.ndarray) -> Measured:
        """Summarise repeats."""
        array = np.asarray(values, dtype=float)
        std = float(array.std(ddof=1)) if len(array) > 1 else 0.0
        return cls(float(array.mean()), std, len(array))


@dataclass(frozen=True)
class ScalarError:
    """Error of one simulated quantity.

    Examples
    --------
    >>> error = ScalarError(110.0, Measured.of([99.0, 101.0]))
    >>> error.ae, error.are
    (10.0, 0.1)
    """

    simulated: float
    measured: Measured

    @property
    def ae(self) -> float:
        """Absolute error |simulated - mean measured|, in the unit of the quantity."""
        return abs(self.simulated - self.measured.mean)

    @property
    def ae_std(self) -> float:
        """Uncertainty of the absolute error: the scatter of the repeats."""
        return self.measured.std

    @property
    def are(self) -> float:
        """Absolute relative error AE / mean measured [1]."""
        return self.ae / abs(self.measured.mean)

    @property
    def are_std(self) -> float:
        """Gaussian propagation of the scatter into |S/M - 1|: S s_M / M^2."""
        return abs(self.simulated) * self.measured.std / self.measured.mean**2

    @property
    def signed(self) -> float:
        """Relative error with its sign: positive where the simulation is too high."""
        return (self.simulated - self.measured.mean) / abs(self.measured.mean)

    def to_dict(self) -> dict[str, float]:
        """Return plain numbers."""
        return {
            "simulated": self.simulated,
            "measured": self.measured.mean,
            "measured_std": self.measured.std,
            "repeats": self.measured.repeats,
            "ae": self.ae,
            "ae_std": self.ae_std,
            "are": self.are,
            "are_std": self.are_std,
            "signed": self.signed,
        }


@dataclass(frozen=True)
class LevelSummary:
    """ARE over the levels of a test plan: mean (MARE) and standard deviation, each with its uncertainty.

    Examples
    --------
    >>> LevelSummary.of([ScalarError(s, Measured.of([100.0])) for s in (110.0, 90.0, 130.0)]).mare
    0.16666666666666666
    """

    mare: float
    mare_std: float
    spread: float
    spread_std: float
    levels: int

    @classmethod
    def of(cls, errors: Sequence[ScalarError]) -> LevelSummary:
        """Summarise the errors of all levels.

        The uncertainties follow from Gaussian propagation of the independent uncertainties u_i of the
        levels: u(mean) = sqrt(sum u_i^2) / n and u(s) = sqrt(sum ((x_i - mean) u_i)^2) / ((n - 1) s).
        """
        x = np.array([e.are for e in errors])
        u = np.array([e.are_std for e in errors])
        n = len(x)
        mean = float(x.mean())
        spread = float(x.std(ddof=1)) if n > 1 else 0.0
        spread_std = 0.0
        if spread > 0.0:
            spread_std = float(np.sqrt(np.sum(((x - mean) * u) ** 2)) / ((n - 1) * spread))
        return cls(mean, float(np.sqrt(np.sum(u**2)) / n), spread, spread_std, n)

    def to_dict(self) -> dict[str, float]:
        """Return plain numbers."""
        return {
            "mare": self.mare,
            "mare_std": self.mare_std,
            "std": self.spread,
            "std_std": self.spread_std,
            "levels": self.levels,
        }
