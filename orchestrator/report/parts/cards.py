"""Cards: numbers side by side, before and after."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from friction_models.common.markup import escape


@dataclass(frozen=True)
class Change:
    """A number before and after (None where nothing was changed), with its unit and decimals to show.

    Examples
    --------
    >>> change = Change("error", before=0.020, after=0.015)
    >>> round(change.relative, 6), change.rose, "fell by 25 %" in change.card()
    (-0.25, False, True)
    """

    name: str
    before: float
    after: float | None
    unit: str = ""
    decimals: int = 4

    @property
    def relative(self) -> float:
        """Change relative to the value before; negative where it fell."""
        return (self.after - self.before) / self.before if self.before and self.after is not None else 0.0

    @property
    def rose(self) -> bool:
        """Whether the number is larger than before."""
        return self.after is not None and self.after > self.before

    def card(self) -> str:
        """Return the card that shows it; it also says so when the number rose."""
        unit = f' <span class="unit">{escape(self.unit)}</span>' if self.unit else ""
        head = f'<div class="card"><p class="name">{escape(self.name)}</p><p class="numbers">'
        if self.after is None:
            return head + f"{self.before:.{self.decimals}f}{unit}</p></div>"
        kind = "rose" if self.rose else "fell"
        change = "unchanged" if self.after == self.before else f"{kind} by {abs(100 * self.relative):.0f} %"
        return head + (
            f'<span class="before">{self.before:.{self.decimals}f}</span><span class="arrow" aria-label="then">&rarr;</span>'
            f'<span class="after">{self.after:.{self.decimals}f}</span>{unit}</p>'
            f'<p class="change {kind}">{change}</p></div>'
        )


def cards(changes: Iterable[Change]) -> str:
    """Return the cards side by side.

    Examples
    --------
    >>> cards([Change("error", 0.020, None, decimals=2)])
    '<div class="cards"><div class="card"><p class="name">error</p><p class="numbers">0.02</p></div></div>'
    """
    return f'<div class="cards">{"".join(c.card() for c in changes)}</div>'


def judged(before: Mapping[str, float], after: Mapping[str, float], said: str = "") -> str:
    """Return the cards of the errors ``rmse`` and ``mae`` of mu on tests that the fit did not see; `said` begins their names."""
    names = {"rmse": "RMS error", "mae": "mean absolute error"}
    return cards(
        Change(f"{said}mu, {name} on tests not seen in the fit", before[key], after[key])
        for key, name in names.items()
    )
