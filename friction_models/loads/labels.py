"""Labels of loads for axes and tables."""

from __future__ import annotations

from .contract import LOADS


def with_unit(name: str) -> str:
    """Return the name of a load with its unit, ``v_rel [mm/s]``; other names unchanged.

    Examples
    --------
    >>> with_unit("v_rel"), with_unit("psi"), with_unit("batch")
    ('v_rel [mm/s]', 'psi', 'batch')
    """
    unit = next((q.unit for q in LOADS if q.name == name), "1")
    return name if unit == "1" else f"{name} [{unit}]"
