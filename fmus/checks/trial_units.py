"""Trial of `check`: units of the loads and of mu, and the SI definitions of all units."""

from __future__ import annotations

import math

from friction_models.loads import LOADS, MU

from ..archive.content import read_description
from ..interface.quantities import unit_base
from ..runtime.fmu_files import UnpackedFmu
from .report import Notes

#: Base units of the SI; rad is left out, as tools disagree on whether an angle has it.
_SI = ("kg", "m", "s", "A", "K", "mol", "cd")


def units(fmu: UnpackedFmu, notes: Notes) -> None:
    """Look at the units by their names and by their definitions."""
    _names(fmu, notes)
    for problem in _wrong_definitions(fmu):
        notes.add(False, problem)


def _names(fmu: UnpackedFmu, notes: Notes) -> None:
    seen = []
    for quantity in (*LOADS, MU):
        for v in fmu.arrays.get(quantity.name, ()):
            if not v.is_float64 or not v.unit:
                continue
            if v.unit not in {quantity.unit, "-" if quantity.unit == "1" else quantity.unit}:
                notes.add(False, f"unit of {v.own!r} is {v.unit!r}, allowed: {quantity.unit!r}")
                return
            seen.append(quantity.name)
    if seen:
        names = ", ".join(dict.fromkeys(seen))
        notes.add(True, f"units of {names} are those of the loads contract")


def _wrong_definitions(fmu: UnpackedFmu) -> list[str]:
    """Return what is wrong with the base units of known units: importers convert by them."""
    found = []
    for unit in read_description(fmu.path).iterfind("UnitDefinitions/Unit"):
        name, given = str(unit.get("name")), unit.find("BaseUnit")
        known = unit_base(name)
        if known is None or given is None:
            continue
        for key in (*_SI, "factor", "offset"):
            default = 1.0 if key == "factor" else 0.0
            wanted, text = float(known.get(key, default)), given.get(key, repr(default))
            try:
                value = float(text)
            except ValueError:
                value = math.nan
            if not math.isclose(value, wanted, rel_tol=1e-9, abs_tol=0.0):
                what = key if key in {"factor", "offset"} else f"exponent of {key}"
                found.append(
                    f"unit {name[:40]!r} is defined with {what} {text[:30]!r}, allowed: {wanted:g} "
                    "(value in the SI = factor * value + offset)"
                )
    return found
