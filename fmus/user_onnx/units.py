"""Units in which a foreign graph may see the loads, derived from the unit table of the FMI variables."""

from __future__ import annotations

from friction_models.common import unknown_name
from friction_models.loads import LOADS, Quantity

from ..interface.quantities import UNITS

#: More spellings and multiples of what the contract measures, as in `fmus.interface.quantities.UNITS`.
_MORE: dict[str, dict[str, float]] = {
    "m/s": {"m": 1, "s": -1},
    "um/s": {"m": 1, "s": -1, "factor": 1e-6},
    "mm/min": {"m": 1, "s": -1, "factor": 1e-3 / 60.0},
    "m/min": {"m": 1, "s": -1, "factor": 1.0 / 60.0},
    "m": {"m": 1},
    "cm": {"m": 1, "factor": 1e-2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "kPa": {"kg": 1, "m": -1, "s": -2, "factor": 1e3},
    "bar": {"kg": 1, "m": -1, "s": -2, "factor": 1e5},
    "N/mm2": {"kg": 1, "m": -1, "s": -2, "factor": 1e6},
    "GPa": {"kg": 1, "m": -1, "s": -2, "factor": 1e9},
    "degF": {"K": 1, "factor": 5.0 / 9.0, "offset": 459.67 * 5.0 / 9.0},
    "%": {"factor": 1e-2},
}
_TABLE = _MORE | UNITS
_SPELLINGS = {
    "°C": "degC",
    "C": "degC",
    "°F": "degF",
    "N/mm^2": "N/mm2",
    "N/mm²": "N/mm2",
    "µm": "um",
    "-": "1",
}


def _dimension(unit: str) -> dict[str, float]:
    return {k: v for k, v in _TABLE[unit].items() if k not in {"factor", "offset"}}


def units_of(load: Quantity) -> list[str]:
    """Return the units that measure a load, its own first.

    Examples
    --------
    >>> from friction_models.loads import LOADS
    >>> {q.name: units_of(q)[:3] for q in LOADS}
    {'v_rel': ['mm/s', 'm/s', 'um/s'], 'T': ['degC', 'degF', 'K'], 'sigma_n': ['MPa', 'Pa', 'kPa'], 'sd': ['mm', 'm', 'cm'], 'psi': ['1', '%']}
    """
    fitting = [u for u in _TABLE if _dimension(u) == _dimension(load.unit)]
    return [load.unit, *(u for u in fitting if u != load.unit)]


def conversion(name: str, unit: str, where: str) -> tuple[float, float]:
    """Return (factor, offset) that turn a load in the contract's unit into `unit`.

    Raises
    ------
    InputError
        The unit does not measure this load; names the nearest one that does.

    Examples
    --------
    >>> conversion("T", "K", "law.yaml"), conversion("sigma_n", "GPa", "law.yaml")
    ((1.0, 273.15), (0.001, 0.0))
    """
    load = next(q for q in LOADS if q.name == name)
    text = _SPELLINGS.get(unit.strip(), unit.strip())
    allowed = units_of(load)
    if text not in allowed:
        raise unknown_name(f"unit of {name!r}", unit, allowed, where)
    own, other = _TABLE[load.unit], _TABLE[text]
    factor = own.get("factor", 1.0) / other.get("factor", 1.0)
    offset = (own.get("offset", 0.0) - other.get("offset", 0.0)) / other.get("factor", 1.0)
    return factor, offset
