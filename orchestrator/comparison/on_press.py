"""Several friction models on the same press levels: how sure their order is, given the scatter of the repeats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from ..force_curves.forces import LevelsComparison, levels_table
from ..force_curves.metrics import ScalarError
from .order import Order, resampled_errors
from .press_study import FailedRun

#: Errors that differ by less than this share of theirs count as equal: the same law fed in another way (one instance a
#: point, values before the first contact) takes other increments, and differs by about half of that.
RESOLVED = 5e-3
#: What models are ordered by, and how it is called.
QUANTITIES = {"max_force": "maximum force", "work": "forming work"}


@dataclass(frozen=True)
class ForcesComparison:
    """Models on press curves.

    Examples
    --------
    Two friction models on two levels; the press gave 100 kN at both:

    >>> from orchestrator.force_curves.forces import ForceCurve, compare_force
    >>> stroke = np.linspace(0.0, 10.0, 50)
    >>> def model(label, *forces):
    ...     curves = [ForceCurve(stroke, force + 0 * stroke) for force in (*forces, 100.0)]
    ...     return LevelsComparison(label, tuple(compare_force(c, curves[-1]) for c in curves[:-1]))
    >>> found = ForcesComparison.of([model("a", 110.0, 130.0), model("b", 105.0, 95.0)], ["cold", "warm"])
    >>> found.orders["max_force"].names
    ['b', 'a']
    """

    results: Sequence[LevelsComparison]  # one a model
    orders: dict[str, Order]  # by the MARE of each of `QUANTITIES`
    names: Sequence[str]  # of the levels
    synthetic: bool = False
    failed: Sequence[FailedRun] = ()  # runs without a result, whose models are not compared
    lubricants: Sequence[str] = ()  # of the levels

    @classmethod
    def of(
        cls,
        results: Sequence[LevelsComparison],
        names: Sequence[str],
        synthetic: bool = False,
        seed: int = 0,
        failed: Sequence[FailedRun] = (),
        lubricants: Sequence[str] = (),
    ) -> ForcesComparison:
        """Order models that ran on the same levels."""
        orders = {}
        for quantity in QUANTITIES:
            errors: list[list[ScalarError]] = [[getattr(x, quantity) for x in r.levels] for r in results]
            simulated = [np.array([e.simulated for e in row]) for row in errors]
            measured = np.array([e.measured.mean for e in errors[0]])
            scatter = np.array([e.measured.std / np.sqrt(max(e.measured.repeats, 1)) for e in errors[0]])
            draws = resampled_errors(simulated, measured, scatter, np.random.default_rng(seed))
            orders[quantity] = Order.of(
                {r.label: getattr(r, quantity).mare for r in results},
                {r.label: d for r, d in zip(results, draws)},
                len(names),
                RESOLVED,
            )
        return cls(results, orders, list(names), synthetic, failed, list(lubricants))

    def to_dict(self) -> dict[str, object]:
        """Return JSON-able data: the models' numbers, and the orders."""
        return {
            "synthetic": self.synthetic,
            "models": [r.to_dict() for r in self.results],
            "ranking": self.orders["max_force"].names,
            "orders": {quantity: order.to_dict("levels") for quantity, order in self.orders.items()},
            "levels": list(self.names),
            "lubricants": list(self.lubricants),
            "remarks": self.remarks(),
            "failed": [asdict(run) for run in self.failed],
        }

    def remarks(self) -> list[str]:
        """Return a sentence for levels of several lubricants, and for each model that is not compared."""
        missing: dict[str, list[FailedRun]] = {}
        for run in self.failed:
            missing.setdefault(run.model, []).append(run)
        lines = [
            f"{model} is not compared: {len(runs)} of {len(self.names)} levels failed ({runs[0].level}: {runs[0].error[:300]})"
            for model, runs in missing.items()
        ]
        if len(self.lubricants) > 1:
            mixed = f"levels of {', '.join(self.lubricants)} count together"
            lines.insert(0, f"{mixed}: a model of one lubricant is judged by all")
        return lines

    def report(self) -> str:
        """Return the table of errors, and what can be said about the order."""
        lines = [levels_table(self.results), ""]
        for quantity, order in self.orders.items():
            shown = ", ".join(f"{n} ({order.chance(n)})" for n in order.names)
            lines.append(f"by {QUANTITIES[quantity]}, probability of being the best: {shown}")
            lines += order.sentences("levels")
        lines += self.remarks()
        return "\n".join(lines)
