"""Result of a forming run, with its files, pictures and page."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from .page import write_report
from .picture import write_picture
from .record import FormingRecord
from .saving import save_result


@dataclass(frozen=True)
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
        return save_result(self, Path(folder), name)

    def report(self, path: str | os.PathLike[str], name: str = "forming") -> Path:
        """Write a self-contained HTML page: key figures, force, animation of the fields, contact."""
        return write_report(self, path, name)
