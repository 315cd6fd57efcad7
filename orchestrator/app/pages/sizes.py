"""How much room a figure needs at least: on a phone it is moved sideways where there is less."""

from __future__ import annotations

from typing import Any

#: Least width of a panel that stands beside others [px]: with less its ticks and titles touch.
PANEL = 210
#: Largest width that a figure may ask for [px].
WIDEST = 2000


def least_width(layout: dict[str, Any]) -> int:
    """Return the least width of a figure [px]: as its `meta` says, or by its panels; 0 for one or two panels beside each other, which fit a phone or follow the style.

    Examples
    --------
    >>> row = {f"xaxis{k}": {"domain": [0.3 * k, 0.3 * k + 0.2]} for k in (1, 2, 3)}
    >>> least_width(row), least_width({"xaxis": {"domain": [0, 1]}})
    (630, 0)
    >>> least_width({"meta": {"least_width": 720}})
    720
    """
    told = layout.get("meta")
    wanted = told.get("least_width") if isinstance(told, dict) else None
    if isinstance(wanted, int):
        return min(wanted, WIDEST)
    axes = [v for k, v in layout.items() if k.startswith("xaxis") and isinstance(v, dict)]
    beside = len({str(a.get("domain")) for a in axes})
    return PANEL * beside if beside > 2 else 0
