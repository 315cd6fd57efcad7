"""Writes a forming result as a folder: key figures, force, contact history, fields."""

from __future__ import annotations

import math
from dataclasses import fields as attributes
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_models.common import atomic_folder, write_json
from friction_models.common.folders import FORMING
from friction_models.loads import LOADS, MU

from .contact_history import ContactHistory
from .ejection_result import save_ejection
from .record import FormingRecord

if TYPE_CHECKING:
    import xarray

#: Attributes of a result with one entry a communication step, and their units.
CURVES = {"stroke": "mm", "force": "kN", "work": "J", "compression": "mm", "expansion": "mm"}


def save_result(result: FormingRecord, folder: Path, name: str) -> Path:
    """Write the folder, which is replaced, and return its path."""
    with atomic_folder(folder, FORMING) as place:
        write_json(place / "forming.json", {"name": name} | key_figures(result))
        curves = {
            f"{k} [{u}]": c for k, u in CURVES.items() if len(c := getattr(result, k)) == len(result.stroke)
        }
        head = ",".join(curves)
        np.savetxt(
            place / "force.csv", np.column_stack(list(curves.values())), "%.9g", ",", header=head, comments=""
        )
        data = contact_dataset(result.contact)
        encoding: Any = {str(v): {"zlib": True, "complevel": 4} for v in data.data_vars}
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


def key_figures(result: FormingRecord) -> dict[str, object]:
    """Return the numbers and texts of a result, those that are one number or one text."""
    found: dict[str, object] = {"max_force": result.max_force}
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
    values: dict[str, object] = {
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
