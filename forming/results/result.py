"""Result of a forming run, with its files, pictures and page."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from dataclasses import fields as attributes
from pathlib import Path

import numpy as np

from friction_models.common import atomic_folder, write_json, write_text
from friction_models.common.folders import FORMING
from friction_models.common.netcdf_files import Dataset, NetcdfVariable, write_dataset
from friction_models.loads import LOADS, MU

from .contact_history import ContactHistory
from .ejection_result import save_ejection
from .pictures.page import report_page
from .pictures.picture import write_picture
from .record import FormingRecord

#: Attributes of a result with one entry a communication step, and their units.
CURVES = {"stroke": "mm", "force": "kN", "work": "J", "compression": "mm", "expansion": "mm"}
#: What the names of stated errors end with.
ERROR = "_error"


@dataclass(frozen=True, repr=False)
class FormingResult(FormingRecord):
    """Result of a forming run: a `FormingRecord` that can be drawn, saved and reported.

    Examples
    --------
    A run makes it; here one by hand, of a force that rises to 100 kN and stays:

    >>> import numpy as np
    >>> from forming import ContactHistory, FormingResult
    >>> stroke, none = np.array([0.0, 5.0, 10.0]), np.zeros((3, 0))
    >>> contact = ContactHistory(stroke, np.zeros((3, 0, 5)), none > 0, none, np.zeros((3, 0, 2)), none)
    >>> force, work = np.array([0.0, 100.0, 100.0]), np.array([0.0, 250.0, 750.0])
    >>> result = FormingResult(stroke, force, work, 0.1, 0.0, 0.0, 0.0, 2, 0, 0, contact)
    >>> result.max_force, result.status, len(result.fields)
    (100.0, 'ok', 0)
    >>> result.to_frame()["work"].tolist()
    [0.0, 250.0, 750.0]
    """

    def picture(self, path: str | os.PathLike[str], field: str = "T", stroke: float | None = None) -> Path:
        """Draw a field over the full cross-section with the tools; return the path.

        Parameters
        ----------
        path : path-like
            ``.svg`` for a drawing, ``.html`` for a page on which stroke and field can be chosen.
        field : str
            One of `forming.results.snapshot.FIELDS`: T, strain, sigma_m ...
        stroke : float, optional
            The snapshot nearest to it is drawn [mm]; by default the last.

        Raises
        ------
        InputError
            No snapshots were kept, an unknown field, another kind of file.
        """
        return write_picture(self.fields, path, field, stroke)

    def save(self, folder: str | os.PathLike[str], name: str = "forming") -> Path:
        """Write ``forming.json``, ``force.csv``, ``contact.nc`` and the fields into a folder, which is replaced.

        ``tribofmu report FOLDER`` makes a page of it; ``fields/fields.pvd`` opens in ParaView.
        """
        with atomic_folder(folder, FORMING) as place:
            write_json(place / "forming.json", {"name": name} | key_figures(self))
            curves = {
                f"{k} [{u}]": c for k, u in CURVES.items() if len(c := getattr(self, k)) == len(self.stroke)
            }
            columns = np.column_stack(list(curves.values()))
            np.savetxt(place / "force.csv", columns, "%.9g", ",", header=",".join(curves), comments="")
            write_dataset(contact_dataset(self.contact), place / "contact.nc")
            if self.ejection is not None:
                save_ejection(self.ejection, place)
                if self.ejection.contact is not None:
                    write_dataset(contact_dataset(self.ejection.contact), place / "ejection_contact.nc")
            if len(self.fields):
                self.fields.write_vtu(place / "fields")
                self.fields.save(place / "fields" / "fields.npz")
        return Path(folder)

    def report(self, path: str | os.PathLike[str], name: str = "forming") -> Path:
        """Write a self-contained HTML page: key figures, force, animation of the fields, contact."""
        return write_text(path, report_page(self, name))


def key_figures(result: FormingRecord) -> dict[str, object]:
    """Return the numbers and texts of a result, those that are one number or one text."""
    found: dict[str, object] = {"max_force": result.max_force}
    for attribute in attributes(result):
        value = getattr(result, attribute.name)
        if isinstance(value, (int, str)) or (isinstance(value, float) and math.isfinite(value)):
            found[attribute.name] = value
        elif isinstance(value, (list, tuple)) and all(isinstance(v, str) for v in value):
            found[attribute.name] = list(value)
    return found | ({"inputs": dict(result.inputs)} if result.inputs else {})


def contact_dataset(contact: ContactHistory) -> Dataset:
    """Return a contact history as a data set over time steps and markers, with units."""
    columns = [(q.name, contact.loads[:, :, k], q.unit, q.meaning) for k, q in enumerate(LOADS)]
    if contact.errors is not None:
        columns += [
            (f"{q.name}{ERROR}", contact.errors[:, :, k], q.unit, f"stated error of {q.name}")
            for k, q in enumerate(LOADS)
        ]
    columns += [
        ("mu", contact.mu, "1", MU.meaning),
        ("tau_over_k", contact.tau_over_k, "1", "friction stress over shear yield stress"),
        ("active", contact.active.astype(np.int8), "1", "in contact (1) or not (0)"),
        ("r", contact.position[:, :, 0], "mm", "r of the marker"),
        ("z", contact.position[:, :, 1], "mm", "z of the marker"),
    ]
    values = {
        name: NetcdfVariable(("step", "point"), array, {"units": unit, "long_name": meaning})
        for name, array, unit, meaning in columns
    }
    return Dataset(values, {"stroke": NetcdfVariable(("step",), contact.stroke, {"units": "mm"})}, {})
