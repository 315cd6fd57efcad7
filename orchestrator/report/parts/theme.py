"""Colours and dashes that hold in print and for colour-blind readers."""

from __future__ import annotations

from collections.abc import Iterable

Look = dict[str, str | float]

INK, SOFT, LINE = "#1b2530", "#566474", "#e1e6eb"
PRESS, PRESS_BAND = "#3d4854", "rgba(61, 72, 84, 0.17)"
BEFORE, AFTER, OTHER, CONSTANT = "#c8641f", "#0a7f79", "#7d62a8", "#9aa4af"
BEFORE_BAND, AFTER_BAND = "rgba(200, 100, 31, 0.16)", "rgba(10, 127, 121, 0.16)"
#: From what is too low over what fits to what is too high.
SIGNED = [[0.0, "#2f6da8"], [0.25, "#9fc3df"], [0.5, "#f4f5f6"], [0.75, "#eeb48a"], [1.0, "#b4531a"]]
#: Axes and what is drawn in lines as thin; a rival of what is named.
AXIS, RIVAL = "#b8c2cc", "#6fb5b1"
#: Colour and dash of a friction model by its part in a comparison.
STYLES: dict[str, Look] = {
    "constant": {"color": CONSTANT, "width": 2, "dash": "dash"},
    "before": {"color": BEFORE, "width": 2},
    "other": {"color": OTHER, "width": 2, "dash": "dot"},
    "after": {"color": AFTER, "width": 2.6},
}
#: Okabe and Ito (2008), Color universal design, without black and yellow, which belong to measurements and notes;
#: two more behind them.
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#6a3d9a", "#7f6a50")
DASHES = ("solid", "dash", "dot", "dashdot")


def looks(names: Iterable[str]) -> dict[str, Look]:
    """Return colour and dash of each name; constant coefficients of friction (numbers) are grey and dashed.

    Examples
    --------
    >>> found = looks(["law", "0.08", "other"])
    >>> found["law"]["color"] != found["other"]["color"], found["0.08"]["dash"]
    (True, 'dash')
    """
    found: dict[str, Look] = {}
    colored = constants = 0
    for name in names:
        if _is_number(name):
            found[name] = {"color": CONSTANT, "width": 2, "dash": DASHES[1 + constants % 3]}
            constants += 1
        else:
            dash = DASHES[colored // len(COLORS) % len(DASHES)]
            found[name] = {"color": COLORS[colored % len(COLORS)], "width": 2, "dash": dash}
            colored += 1
    return found


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
