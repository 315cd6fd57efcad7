"""`FormulaOffer`: empirical terms that predict unseen tests better, and how much."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ...effects.base import Effect
from .pictures import TermCurve


@dataclass(frozen=True)
class FormulaOffer:
    """One empirical term, or two or three that belong together; nothing adds them but `refine`.

    All errors are those of whole tests that took no part: for each fold of the tests, the terms were chosen and fitted anew without it.

    Examples
    --------
    >>> from friction_models.effects import make_effect
    >>> offer = FormulaOffer("empirical:bump(T)", "mu += ...", 0.9, (0.8, 1.0), 1.0, (make_effect("empirical:bump(T)"),))
    >>> offer.effects[0].driver
    ('T',)
    """

    name: str  #: What `refine` adds, ``empirical:bump(T)``; of several terms, their names joined by ``and``.
    equation: str  #: With numbers.
    #: Share of the squared error known to be avoidable on unseen tests that it removes there. Avoidable is what the flexible
    #: reference or this term removes, whichever is more: nobody knows more of it.
    share: float
    interval: tuple[float, float]  #: 95 % interval of it over the tests.
    #: Share of resamples of whole tests in which a term of the same loads and kind of curve comes first; the least of several.
    stability: float
    effects: tuple[Effect, ...] = field(repr=False)
    #: Error of mu on unseen tests, before and after, the scatter of the tests included.
    rms: tuple[float, float] = (float("nan"), float("nan"))
    #: Fitted shape parameters of each effect.
    shapes: tuple[dict[str, float], ...] = field(default=(), repr=False)
    curves: tuple[TermCurve, ...] = field(default=(), repr=False)  #: What it adds to mu, with interval.

    @property
    def names(self) -> list[str]:
        """What `refine` adds."""
        return [e.name for e in self.effects]

    @property
    def resamples(self) -> str:
        """How often it came first in resamples, in words; where never, what it was chosen for."""
        if self.stability > 0.0:
            return f"first in {self.stability:.0%} of resamples"
        it = "it" if len(self.effects) < 2 else "one of the terms"
        return f"chosen for its error on unseen tests; {it} was first in none of the resamples"

    def to_dict(self) -> dict[str, object]:
        """Return what ``diagnose --json`` writes of it."""
        fitted = {e.name: dict(shape) for e, shape in zip(self.effects, self.shapes)}
        return {
            "name": self.name,
            "add": self.names,
            "equation": self.equation,
            "shapes": fitted,
            "share": self.share,
            "interval": list(self.interval),
            "stability": self.stability,
            "rms_before": self.rms[0],
            "rms_after": self.rms[1],
        }


def offer_lines(offers: Sequence[FormulaOffer]) -> list[str]:
    """Return offers as lines of a report.

    Examples
    --------
    >>> offer_lines([FormulaOffer("empirical:bump(T)", "mu += ...", 0.9, (0.8, 1.0), 1.0, (), (0.008, 0.005))])[1]
    '  empirical:bump(T): rms error on unseen tests 0.0080 -> 0.0050; 90 % (80 to 100 %) of what is known to be avoidable of its square; first in 100 % of resamples'
    """
    if not offers:
        return []
    lines = [
        "Empirical terms that would lower the error (no law behind them; chosen and fitted without the tests that judge them; "
        "not added: refine --add 'NAME')"
    ]
    for o in offers:
        low, high = o.interval
        lines.append(
            f"  {o.name}: rms error on unseen tests {o.rms[0]:.4f} -> {o.rms[1]:.4f}; {o.share:.0%} ({100 * low:.0f} to {high:.0%}) "
            f"of what is known to be avoidable of its square; {o.resamples}".replace("%", " %")
        )
        lines.append(f"    {o.equation}")
    return lines
