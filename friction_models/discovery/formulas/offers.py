"""`FormulaOffer`: empirical terms that predict unseen tests better, and how much."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ...effects.base import Effect


@dataclass(frozen=True)
class FormulaOffer:
    """One empirical term, or two that belong together; nothing adds them but `refine`.

    Attributes
    ----------
    name : str
        What `refine` adds, ``empirical:bump(T)``; of two terms, both names joined by ``and``.
    equation : str
        With numbers.
    share : float
        Share of the squared error that the model misses (what can be predicted on unseen tests and is not) that it removes there.
    interval : tuple of float
        95 % interval of it over the tests.
    stability : float
        Share of resamples of whole tests in which a term of the same loads and kind of curve comes first.
    effects : tuple of Effect

    Examples
    --------
    >>> from friction_models.effects import make_effect
    >>> offer = FormulaOffer("empirical:bump(T)", "mu += ...", 0.9, (0.8, 1.0), 1.0, (make_effect("empirical:bump(T)"),))
    >>> offer.effects[0].driver
    ('T',)
    """

    name: str
    equation: str
    share: float
    interval: tuple[float, float]
    stability: float
    effects: tuple[Effect, ...] = field(repr=False)


def offer_lines(offers: Sequence[FormulaOffer]) -> list[str]:
    """Return offers as lines of a report.

    Examples
    --------
    >>> offer_lines([FormulaOffer("empirical:bump(T)", "mu += ...", 0.9, (0.8, 1.0), 1.0, ())])[1]
    '  empirical:bump(T): removes 90 % (80 to 100 %) of the missing squared error on unseen tests; first in 100 % of resamples'
    """
    if not offers:
        return []
    lines = [
        "Empirical terms that would lower the error (no law behind them; not added: refine --add 'NAME')"
    ]
    for o in offers:
        low, high = o.interval
        lines.append(
            f"  {o.name}: removes {o.share:.0%} ({100 * low:.0f} to {high:.0%}) of the missing squared error on unseen tests; "
            f"first in {o.stability:.0%} of resamples".replace("%", " %")
        )
        lines.append(f"    {o.equation}")
    return lines
