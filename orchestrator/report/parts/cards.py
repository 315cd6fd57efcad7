"""Cards: numbers side by side, before and after."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from friction_models.common.markup import escape

#: Lowest and highest value; None or NaN where it is not known.
Interval: TypeAlias = "Sequence[float] | None"
#: What stands below errors before and after an addition.
INTERVALS = (
    "The 95 % intervals count a whole test as one observation, and that of the fall takes the same tests for both; a fall is more than "
    "chance where the RMS error falls in 97.5 % of the resampled sets of at least 6 tests, and a rise where "
    "it rises in as many."
)


def with_interval(value: float, interval: Interval, sign: str = "") -> str:
    """Return a number with its 95 % interval in brackets, as all pages have it; alone where that is not known.

    Examples
    --------
    >>> with_interval(0.005, (0.004, 0.0061)), with_interval(0.005, None), with_interval(0.01, (-0.02, 0.04), "+")
    ('0.0050 [0.0040, 0.0061]', '0.0050', '+0.0100 [-0.0200, +0.0400]')
    """
    text = f"{value:{sign}.4f}"
    if interval is None or math.isnan(interval[0]):
        return text
    return f"{text} [{', '.join(f'{edge:{sign}.4f}' for edge in interval)}]"


def chance(entry: Mapping[str, Any]) -> str:
    """Return in words whether the error of a round changed by more than chance; empty where that is not known.

    Examples
    --------
    >>> chance({"clear": True})
    'more than chance'
    """
    # It brings all models, for which pages without rounds do not wait.
    from friction_models.families.refinement_history import chance_text

    return chance_text(entry)


@dataclass(frozen=True)
class Change:
    """A number before and after (None where nothing was changed), with its unit and decimals to show.

    `said` is what more there is to say of the change, `intervals` the 95 % intervals of both numbers and of the fall.

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
    said: str = ""
    intervals: Sequence[Interval] = ()

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
            f'<p class="change {kind}">{change}{f": {escape(self.said)}" if self.said else ""}</p>{self._sure()}</div>'
        )

    def _sure(self) -> str:
        """Return the intervals in words."""
        known = [
            [f"{edge:.{self.decimals}f}" for edge in found] for found in self.intervals if found is not None
        ]
        if len(known) < 2:
            return ""
        said = [f"{low} to {high}" for low, high in known]
        fall = f"; the fall {said[2]}" if len(said) > 2 else ""
        return f'<p class="interval">95 %: {said[0]}, then {said[1]}{fall}</p>'


def cards(changes: Iterable[Change]) -> str:
    """Return the cards side by side.

    Examples
    --------
    >>> cards([Change("error", 0.020, None, decimals=2)])
    '<div class="cards"><div class="card"><p class="name">error</p><p class="numbers">0.02</p></div></div>'
    """
    return f'<div class="cards">{"".join(c.card() for c in changes)}</div>'


def judged(first: Mapping[str, Any], last: Mapping[str, Any], said: str = "") -> str:
    """Return the cards of the errors of mu on tests that the fit did not see; `said` begins their names.

    They go from ``before`` the `first` round of additions to ``after`` the `last` one, which may be the same; a round
    of an older file has no intervals.
    """
    names = {"rmse": "RMS error", "mae": "mean absolute error"}
    found = [(first, "before"), (last, "after"), *([(last, "fall")] if first is last else [])]
    clear = chance(last) if first is last else ""

    def intervals(key: str) -> list[Interval]:
        return [entry.get("intervals", {}).get(when, {}).get(key) for entry, when in found]

    return cards(
        Change(
            f"{said}mu, {name} on tests not seen in the fit", first["before"][key], last["after"][key],
            # Chance is judged by the RMS error.
            said=clear if key == "rmse" else "", intervals=intervals(key),
        )
        for key, name in names.items()
    )  # fmt: skip


def in_numbers(entry: Mapping[str, Any], key: str) -> tuple[str, str, str]:
    """Return an error before and after a round of additions, and its fall, each with its interval where that is known."""
    before, after = entry["before"][key], entry["after"][key]
    intervals = {when: part.get(key) for when, part in entry.get("intervals", {}).items()}
    return (
        with_interval(before, intervals.get("before")),
        with_interval(after, intervals.get("after")),
        with_interval(before - after, intervals.get("fall"), sign="+"),
    )
