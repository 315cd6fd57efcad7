"""How sure the order of friction models is: on tests or press levels that are drawn anew again and again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypedDict

import numpy as np

from friction_models.discovery.resampling import FEWEST_TESTS, SAME
from friction_models.loads import FloatArray

#: Resampled sets of tests, and how sure an order has to be.
REPLICATES = 4000
SURE = 0.95
#: With fewer tests or levels than this no two models are told apart, as none is clearly ahead.
FEWEST_UNITS = FEWEST_TESTS


class Pair(TypedDict):
    """Two models."""

    better: str
    worse: str
    difference: float  # by which the error of the worse one is larger
    interval: list[float]  # of the difference, 95 %
    probability: float  # that the better one is better indeed
    apart: bool  # whether they can be told apart


@dataclass(frozen=True)
class Order:
    """How sure the order of models is, from resampling whole tests (or press levels) for all models alike.

    Examples
    --------
    >>> errors = {"a": 0.010, "b": 0.020}
    >>> draws = {"a": np.array([0.009, 0.011, 0.010]), "b": np.array([0.019, 0.021, 0.010])}
    >>> order = Order.of(errors, draws, units=3)
    >>> order.names, round(order.best["a"], 3), order.indistinct
    (['a', 'b'], 0.833, [('a', 'b')])
    """

    names: list[str]  # best first
    best: dict[str, float]  # probability of being the best of all
    ranks: dict[str, tuple[int, int]]  # 95 % interval of the place, 1 is the best
    pairs: list[Pair]
    units: int  # number of tests or levels

    @classmethod
    def of(
        cls, errors: Mapping[str, float], draws: Mapping[str, FloatArray], units: int, same: float = SAME
    ) -> Order:
        """Order models by an error.

        `errors` are those of each model, smaller is better; `draws` the same in every resampled set, all models in
        the same sets; `units` is the number of tests or levels that were resampled. Errors that differ by less than
        the share `same` of theirs count as equal.
        """
        names = sorted(errors, key=lambda n: errors[n])
        table = np.array([draws[n] for n in names])
        # The same law in two files differs by rounding and by what the solver resolves, which decides nothing.
        places = 1 + (table[:, None, :] > (1.0 + same) * table[None, :, :]).sum(axis=1)
        first = (table <= (1.0 + same) * table.min(axis=0)).astype(float)
        best = (first / first.sum(axis=0)).mean(axis=1)
        low, high = np.quantile(places, [0.025, 0.975], axis=1, method="nearest")
        pairs: list[Pair] = []
        tail = 0.5 * (1.0 - SURE)
        for i, j in combinations(range(len(names)), 2):
            change = table[j] - table[i]
            resolved = same * float(np.max(table[[i, j]]))
            interval = np.quantile(change, [tail, 1.0 - tail]).tolist()
            pairs.append(
                {
                    "better": names[i],
                    "worse": names[j],
                    "difference": errors[names[j]] - errors[names[i]],
                    "interval": interval,
                    "probability": float(
                        np.mean(change > resolved) + 0.5 * np.mean(np.abs(change) <= resolved)
                    ),
                    "apart": bool(interval[0] > resolved and units >= FEWEST_UNITS),
                }
            )
        ranks = {n: (int(a), int(b)) for n, a, b in zip(names, low, high)}
        return cls(names, dict(zip(names, best.tolist())), ranks, pairs, units)

    @property
    def judged(self) -> bool:
        """Whether there are enough tests (or levels) for an order of models."""
        return self.units >= FEWEST_UNITS

    def chance(self, name: str) -> str:
        """Return how probably a model is the best of all, in words."""
        return f"{100 * self.best[name]:.0f} %" if self.judged else "not known"

    def place(self, name: str, to: str = "-") -> str:
        """Return the 95 % interval of the place of a model, in words."""
        low, high = self.ranks[name]
        if not self.judged and len(self.names) > 1:
            return "not known"
        return f"{low}" if low == high else f"{low}{to}{high}"

    @property
    def indistinct(self) -> list[tuple[str, str]]:
        """Pairs that cannot be told apart."""
        return [(p["better"], p["worse"]) for p in self.pairs if not p["apart"]]

    def sentences(self, unit: str = "tests") -> list[str]:
        """Return what can be said about the order."""
        if len(self.names) < 2:
            return []
        lines = []
        pairs = self.indistinct
        if pairs:
            shown = ", ".join(f"{a} and {b}" for a, b in pairs[:6]) + (
                f" and {len(pairs) - 6} more pairs" if len(pairs) > 6 else ""
            )
            words = f"{self.units} {unit}" if self.units != 1 else f"1 {unit.removesuffix('s')}"
            lines.append(f"cannot be told apart on {words}: {shown}")
        if not self.judged:
            lines.append(self._too_few(unit))
        return lines

    def _too_few(self, unit: str) -> str:
        return f"at least {FEWEST_UNITS} {unit} are needed to tell models apart"

    def to_dict(self, unit: str = "tests") -> dict[str, object]:
        """Return JSON-able data; where the order is not known its numbers are None, and ``reason`` says why."""
        return {
            "units": self.units,
            "best": {n: self.best[n] if self.judged else None for n in self.names},
            "ranks": {n: self.rank(n) for n in self.names},
            "pairs": [p if self.judged else {**p, "interval": None, "probability": None} for p in self.pairs],
            "indistinct": [list(p) for p in self.indistinct],
            "reason": None if self.judged else self._too_few(unit),
        }

    def rank(self, name: str) -> list[int] | None:
        """Return the 95 % interval of the place of a model; None where it is not known."""
        return list(self.ranks[name]) if self.judged or len(self.names) == 1 else None


def resampled_errors(
    simulated: Sequence[FloatArray], measured: FloatArray, deviation: FloatArray, rng: np.random.Generator
) -> list[FloatArray]:
    """Return the mean absolute relative error of each model in resampled sets of press levels.

    Levels are drawn with replacement, and the measured mean of each is drawn from its own uncertainty, the
    standard deviation of the repeats over the root of their number; all models in the same sets. All arrays have the
    shape (levels,): `simulated` one a model, `measured` the mean of the repeats, `deviation` that of this mean.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> measured = np.array([100.0, 200.0])
    >>> (errors,) = resampled_errors([1.1 * measured], measured, 0.0 * measured, rng)
    >>> round(float(errors.min()), 6), round(float(errors.max()), 6)
    (0.1, 0.1)
    """
    levels = len(measured)
    chosen = rng.integers(0, levels, (REPLICATES, levels))
    drawn = measured[chosen] + deviation[chosen] * rng.standard_normal((REPLICATES, levels))
    drawn = np.where(np.abs(drawn) < 1e-9, 1e-9, drawn)
    return [np.asarray(np.mean(np.abs(s[chosen] / drawn - 1.0), axis=1)) for s in simulated]
