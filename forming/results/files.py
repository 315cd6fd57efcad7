"""Reads a forming result from its folder."""

from __future__ import annotations

import json
import os
from dataclasses import fields as attributes
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common import InputError, given_path
from friction_models.common.netcdf_files import read_numbers
from friction_models.common.netcdf_quantities import check_shapes, in_units
from friction_models.loads import LOADS

from .contact_history import ContactHistory
from .ejection_result import load_ejection
from .fields import FieldHistory
from .result import CURVES, ERROR, FormingResult

#: Most entries of an array that is read back: 1e4 steps of 1e3 markers and five loads.
_MOST = 50_000_000


def load_result(folder: str | os.PathLike[str]) -> tuple[FormingResult, str]:
    """Read a folder that `FormingResult.save` wrote; return the result and its name.

    Raises InputError: files are missing or cannot be read.
    """
    place = given_path(folder, "a forming result")
    for name in ("forming.json", "force.csv", "contact.nc"):
        if not (place / name).is_file():
            raise InputError(f"{place}: not the folder of a forming result ({name} is missing)")
    try:
        figures = json.loads((place / "forming.json").read_text(encoding="utf-8"))
        with (place / "force.csv").open(encoding="utf-8") as stream:
            head = [column.partition(" [")[0] for column in stream.readline().strip().split(",")]
            table = np.atleast_2d(np.loadtxt(stream, delimiter=",", dtype=np.float64))
        if not np.isfinite(table).all() or not {"stroke", "force", "work"} <= set(head) <= set(CURVES):
            raise ValueError("force.csv holds other columns, or numbers that are not finite")
        contact = _read_contact(place / "contact.nc")
        ejection = load_ejection(place)
        moved = place / "ejection_contact.nc"
        if ejection is not None and moved.is_file():
            ejection = replace(ejection, contact=_read_contact(moved))
        known = {a.name for a in attributes(FormingResult)} - {"contact", "fields", "ejection", *CURVES}
        plain: dict[str, Any] = {
            k: tuple(v) if isinstance(v, list) else v for k, v in figures.items() if k in known
        }
        plain["inputs"] = dict(plain.get("inputs", {}))
        name = str(figures.get("name", place.name))
        plain |= {column: table[:, k].copy() for k, column in enumerate(head)}
    except InputError:
        raise
    except (OSError, ValueError, KeyError, RuntimeError, TypeError, AttributeError) as error:
        raise InputError(
            f"{place}: the result cannot be read ({' '.join(str(error).split())[:200]})"
        ) from None
    kept = place / "fields" / "fields.npz"
    history = FieldHistory.load(kept) if kept.is_file() else FieldHistory(())
    try:
        return FormingResult(**plain, contact=contact, fields=history, ejection=ejection), name
    except TypeError:
        raise InputError(f"{place}: forming.json does not hold all numbers of a result") from None


def _read_contact(path: Path) -> ContactHistory:
    loads = [q.name for q in LOADS]
    points = [*loads, "active", "mu", "r", "z", "tau_over_k"]
    numbers = read_numbers(path, ["stroke", *points], _MOST)
    stated = [name + ERROR for name in loads]
    units = {"stroke": "mm", "r": "mm", "z": "mm", "mu": "1", "tau_over_k": "1"}
    units |= {name: q.unit for q in LOADS for name in (q.name, q.name + ERROR)}
    found = in_units(numbers, units, path, differences=stated)
    known = all(name in found for name in stated)
    check_shapes(found, [*points, *stated] if known else points, found["stroke"], path)
    active = found["active"] > 0
    for name in loads:
        if not np.isfinite(found[name][active]).all():
            raise InputError(f"{path}: variable {name!r} is not finite in contact; allowed: finite numbers")
    return ContactHistory(
        stroke=found["stroke"],
        loads=np.stack([found[name] for name in loads], axis=2),
        active=active,
        mu=found["mu"],
        position=np.stack([found["r"], found["z"]], axis=2),
        tau_over_k=found["tau_over_k"],
        errors=np.stack([found[name] for name in stated], axis=2) if known else None,
    )
