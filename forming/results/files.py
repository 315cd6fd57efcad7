"""A forming result as a folder: key figures, force, contact history, fields; written and read back."""

from __future__ import annotations

import json
import math
import os
from dataclasses import fields as attributes
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_models.common import InputError, atomic_folder, write_json
from friction_models.common.folders import FORMING
from friction_models.loads import LOADS, MU

from .ejection_result import load_ejection, save_ejection
from .fields import FieldHistory
from .history import ContactHistory, FormingResult

if TYPE_CHECKING:
    import xarray

#: Attributes of a result with one entry a communication step, and their units.
_CURVES = {"stroke": "mm", "force": "kN", "work": "J", "compression": "mm", "expansion": "mm"}
#: Most entries of an array that is read back: 1e4 steps of 1e3 markers and five loads.
_MOST = 50_000_000


def save_result(result: FormingResult, folder: Path, name: str) -> Path:
    """Write the folder, which is replaced, and return its path."""
    with atomic_folder(folder, FORMING) as place:
        write_json(place / "forming.json", {"name": name} | key_figures(result))
        curves = {
            f"{k} [{u}]": c for k, u in _CURVES.items() if len(c := getattr(result, k)) == len(result.stroke)
        }
        head = ",".join(curves)
        np.savetxt(
            place / "force.csv", np.column_stack(list(curves.values())), "%.9g", ",", header=head, comments=""
        )
        encoding: Any = {}
        data = contact_dataset(result.contact)
        encoding = {str(v): {"zlib": True, "complevel": 4} for v in data.data_vars}
        data.to_netcdf(place / "contact.nc", engine="netcdf4", encoding=encoding)
        if result.ejection is not None:
            save_ejection(result.ejection, place)
            if result.ejection.contact is not None:
                moved = contact_dataset(result.ejection.contact)
                moved.to_netcdf(place / "ejection_contact.nc", engine="netcdf4", encoding=encoding)
        if len(result.fields):
            result.fields.write_vtu(place / "fields")
            result.fields.save(place / "fields" / "fields.npz")
    return folder


def key_figures(result: FormingResult) -> dict[str, Any]:
    """Return the numbers and texts of a result, those that are one number or one text."""
    found: dict[str, Any] = {"max_force": result.max_force}
    for attribute in attributes(result):
        value = getattr(result, attribute.name)
        if isinstance(value, (int, str)) or (isinstance(value, float) and math.isfinite(value)):
            found[attribute.name] = value
        elif isinstance(value, (list, tuple)) and all(isinstance(v, str) for v in value):
            found[attribute.name] = list(value)
    return found


def contact_dataset(contact: ContactHistory) -> xarray.Dataset:
    """Return a contact history as a data set over time steps and markers, with units."""
    import xarray

    both = ("step", "point")
    values: dict[str, Any] = {
        q.name: (both, contact.loads[:, :, k], {"units": q.unit, "long_name": q.meaning})
        for k, q in enumerate(LOADS)
    }
    values["mu"] = (both, contact.mu, {"units": "1", "long_name": MU.meaning})
    meaning = "friction stress over shear yield stress"
    values["tau_over_k"] = (both, contact.tau_over_k, {"units": "1", "long_name": meaning})
    values["active"] = (
        both,
        contact.active.astype(np.int8),
        {"units": "1", "long_name": "in contact (1) or not (0)"},
    )
    for k, axis in enumerate("rz"):
        values[axis] = (
            both,
            contact.position[:, :, k],
            {"units": "mm", "long_name": f"{axis} of the marker"},
        )
    return xarray.Dataset(values, coords={"stroke": ("step", contact.stroke, {"units": "mm"})})


def load_result(folder: str | os.PathLike[str]) -> tuple[FormingResult, str]:
    """Read a folder that `FormingResult.save` wrote; return the result and its name.

    Raises
    ------
    InputError
        Files are missing or cannot be read.
    """

    place = Path(folder)
    for name in ("forming.json", "force.csv", "contact.nc"):
        if not (place / name).is_file():
            raise InputError(f"{place}: not the folder of a forming result ({name} is missing)")
    try:
        figures = json.loads((place / "forming.json").read_text(encoding="utf-8"))
        with (place / "force.csv").open(encoding="utf-8") as stream:
            head = [column.partition(" [")[0] for column in stream.readline().strip().split(",")]
            table = np.atleast_2d(np.loadtxt(stream, delimiter=",", dtype=np.float64))
        if not np.isfinite(table).all() or not {"stroke", "force", "work"} <= set(head) <= set(_CURVES):
            raise ValueError("force.csv holds other columns, or numbers that are not finite")
        contact = _read_contact(place / "contact.nc")
        ejection = load_ejection(place)
        moved = place / "ejection_contact.nc"
        if ejection is not None and moved.is_file():
            ejection = replace(ejection, contact=_read_contact(moved))
        known = {a.name for a in attributes(FormingResult)} - {"contact", "fields", "ejection", *_CURVES}
        plain: dict[str, Any] = {
            k: tuple(v) if isinstance(v, list) else v for k, v in figures.items() if k in known
        }
        name = str(figures.get("name", place.name))
        read: dict[str, Any] = {column: table[:, k].copy() for k, column in enumerate(head)}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(
            f"{place}: the result cannot be read ({' '.join(str(error).split())[:200]})"
        ) from None
    kept = place / "fields" / "fields.npz"
    history = FieldHistory.load(kept) if kept.is_file() else FieldHistory(())
    try:
        return FormingResult(**read, **plain, contact=contact, fields=history, ejection=ejection), name
    except TypeError:
        raise InputError(f"{place}: forming.json does not hold all numbers of a result") from None


def _read_contact(path: Path) -> ContactHistory:
    """Read a contact history; raises ValueError or KeyError for anything else."""
    import xarray

    with xarray.open_dataset(path, engine="netcdf4") as data:
        if sum(v.size for v in data.data_vars.values()) > _MOST:
            raise ValueError("the contact history is too large")
        loads = [np.asarray(data[q.name].values, dtype=np.float64) for q in LOADS]
        return ContactHistory(
            stroke=np.asarray(data["stroke"].values, dtype=np.float64),
            loads=np.stack(loads, axis=2),
            active=np.asarray(data["active"].values) > 0,
            mu=np.asarray(data["mu"].values, dtype=np.float64),
            position=np.stack([np.asarray(data[axis].values) for axis in "rz"], axis=2),
            tau_over_k=np.asarray(data["tau_over_k"].values, dtype=np.float64),
        )
