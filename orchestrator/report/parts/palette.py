"""Colours and dashes for curves in one chart, for colour-blind readers too."""

from __future__ import annotations

from collections.abc import Iterable

from .theme import CONSTANT

#: Okabe and Ito (2008), Color universal design, without black and yellow, which belong to measurements and notes;
#: two more behind them.
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#6a3d9a", "#7f6a50")
DASHES = ("solid", "dash", "dot", "dashdot")


def looks(names: Iterable[str]) -> dict[str, dict[str, str | float]]:
    """Return colour and dash of each name; constant coefficients of friction (numbers) are grey and dashed.

    Examples
    --------
    >>> found = looks(["law", "0.08", "other"])
    >>> found["law"]["color"] != found["other"]["color"], found["0.08"]["dash"]
    (True, 'dash')
    """
    found: dict[str, dict[str, str | float]] = {}
    colored = constants = 0
    for name in names:
        if _is_number(name):
            found[name] = {"color": CONSTANT, "width": 2, "dash": DASHES[1 + constants % 3]}
            constants += 1
            continue
        found[name] = {
            "color": COLORS[colored % len(COLORS)],
            "width": 2,
            "dash": DASHES[colored // len(COLORS) % len(DASHES)],
        }
        colored += 1
    return found


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
