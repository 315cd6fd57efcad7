"""The loads that a forming process puts on its contacts: from a run folder, or from another code's export."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from fmus.interface.quantities import load_conversion
from friction_models.common import InputError, unknown_name
from friction_models.loads import LOAD_NAMES, MU, FloatArray, missing_column
from friction_models.loads.contract import QUANTITIES

from ..cosim.run_folders import Run

#: What a history may hold beside the five loads and mu; factors to the unit named first.
EXTRAS: dict[str, dict[str, float]] = {
    "area": {"mm2": 1.0, "cm2": 1e2, "m2": 1e6},
    "t": {"s": 1.0, "ms": 1e-3},
    "point": {},
}
COLUMNS: tuple[str, ...] = (*LOAD_NAMES, MU.name, *EXTRAS)
#: Pressure below which a point does not count as touching [MPa].
TOUCHING = 1e-3
#: More contact states than this are thinned evenly; the shares do not change by 0.1 % then.
MOST_ROWS = 200_000
_BRACKET = re.compile(r"^(.*\S)\s*\[([^\[\]]*)\]\s*$")
_UNIT_NAMES = {"-": "1", "": "", "mm^2": "mm2", "mm²": "mm2", "cm²": "cm2", "m²": "m2", "m^2": "m2"}


@dataclass(frozen=True)
class ContactStates:
    """Contact states of a forming process, each with how much it counts.

    Examples
    --------
    Two contact states of equal area; the second slides twice as fast, so that it does twice the work:

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "contact.csv"
    ...     _ = file.write_text(chr(10).join(["v_rel,sigma_n", "10,600", "20,600"]))
    ...     history = ContactStates.read(file)
    >>> history.present, history.area, history.work
    (('v_rel', 'sigma_n'), array([0.5, 0.5]), array([0.33333333, 0.66666667]))
    """

    loads: FloatArray  # shape (n, 5), as in the contract; NaN in a column that the source does not hold
    area: FloatArray  # shape (n,), share of contact area and time of each state
    work: FloatArray  # shape (n,), share of the friction work of each state
    source: str
    synthetic: bool = False  # whether the source says of itself that synthetic data are involved
    notes: tuple[str, ...] = ()  # what was assumed

    @property
    def present(self) -> tuple[str, ...]:
        """Names of the loads that the source holds."""
        return tuple(n for n, column in zip(LOAD_NAMES, self.loads.T) if np.isfinite(column).all())

    @classmethod
    def of_run(cls, run: Run) -> ContactStates:
        """Return the contact states of a co-simulation run.

        Markers count alike in the undeformed billet, hence by their surface expansion in the contact.
        """
        names = LOAD_NAMES
        components = [label.rpartition(".")[0] for label in run.values if label.endswith(f".{names[0]}")]
        chosen = [c for c in components if all(f"{c}.{n}" in run.values for n in names)]
        chosen.sort(key=lambda c: run.values[f"{c}.{names[0]}"].ndim != 2 or f"{c}.active" not in run.values)
        if not chosen:
            raise InputError(
                f"{run.folder}: no component recorded {', '.join(names)}; recorded: {', '.join(run.values)}"
            )
        component = chosen[0]
        table = [np.atleast_2d(run.values[f"{component}.{n}"].T).T for n in names]
        touching = table[2] > TOUCHING
        if f"{component}.active" in run.values:
            touching &= np.atleast_2d(run.values[f"{component}.active"].T).T > 0.5
        label = next(
            (x for x in run.values if x.endswith(".mu") and run.values[x].shape == table[0].shape), None
        )
        mu = run.values[label] if label is not None else np.ones_like(table[0])
        dt = np.broadcast_to(np.gradient(run.time)[:, None], table[0].shape)
        notes = ["contact points count alike in the undeformed billet, and by their expansion in the contact"]
        if label is None:
            notes.append("no mu was recorded: friction work is taken with one mu everywhere")
        loads = np.column_stack([column[touching] for column in table])
        area = (table[4] * dt)[touching]
        return _history(loads, area, mu[touching], str(run.folder), run.synthetic, notes)

    @classmethod
    def read(cls, path: str | os.PathLike[str], columns: Mapping[str, str] | None = None) -> ContactStates:
        """Read a contact history that another code exported: one row a contact point and time.

        The file is CSV (comma, semicolon or tab; units in the header or in a row below it). `columns` is
        ``{"sigma_n": "Contact pressure"}``, or with a unit ``"Contact pressure [GPa]"``: the column of each load, of
        ``mu``, of ``area``, of ``t`` and of ``point`` (number of the contact point); columns that are called like these
        need no entry.
        """
        from sct_twin.readers import read_csv

        table = read_csv(path)
        where = table.source
        found: dict[str, FloatArray] = {}
        asked = dict(columns or {})
        for name in asked:
            if name not in COLUMNS:
                raise unknown_name("quantity of a contact history", name, COLUMNS)
        for name in COLUMNS:
            wanted = asked.get(name, name).strip()
            unit = None
            if match := _BRACKET.match(wanted):
                wanted, unit = match[1], match[2].strip()
            if wanted not in table.frame.columns:
                if name in asked:
                    raise missing_column(wanted, table.frame.columns, where)
                continue
            unit = unit if unit is not None else table.units.get(wanted, "")
            found[name] = _converted(name, table.frame[wanted], unit, where)
        rows = len(table.frame)
        loads = [found.get(name, np.full(rows, np.nan)) for name in LOAD_NAMES]
        absent = [name for name in LOAD_NAMES if name not in found]
        if len(absent) == len(LOAD_NAMES):
            raise InputError(
                f"{where}: none of its columns is a load ({', '.join(map(str, table.frame.columns))[:200]}); "
                f"allowed: columns {', '.join(LOAD_NAMES)}, or --column sigma_n=NAME for each"
            )
        notes = list(table.notes)
        if absent:
            notes.append(f"the history lacks {', '.join(absent)}: not judged")
        touching = found["sigma_n"] > TOUCHING if "sigma_n" in found else np.ones(rows, dtype=bool)
        area = found.get("area", np.ones(rows))
        if "area" not in found:
            notes.append("the history has no area: all rows count alike")
        if "t" in found:
            area = area * _durations(found["t"], found.get("point"))
        if "mu" not in found:
            notes.append("the history has no mu: friction work is taken with one mu everywhere")
        mu = found.get("mu", np.ones(rows))
        return _history(np.column_stack(loads)[touching], area[touching], mu[touching], where, False, notes)


def _history(
    loads: FloatArray, area: FloatArray, mu: FloatArray, source: str, synthetic: bool, notes: list[str]
) -> ContactStates:
    if not len(loads) or not area.sum() > 0.0:
        raise InputError(
            f"{source}: nothing is in contact; allowed: rows with sigma_n above {TOUCHING:g} MPa"
        )
    if len(loads) > MOST_ROWS:
        step = len(loads) // MOST_ROWS + 1
        notes.append(f"every {step}. of {len(loads)} contact states was used")
        loads, area, mu = loads[::step], area[::step], mu[::step]
    power = np.nan_to_num(loads[:, 2], nan=1.0) * np.nan_to_num(loads[:, 0], nan=1.0)
    work = mu * power * area
    if not work.sum() > 0.0:
        work = area
        notes.append("nothing slides: friction work is replaced by contact area")
    return ContactStates(loads, area / area.sum(), work / work.sum(), source, synthetic, tuple(notes))


def _converted(name: str, values: pd.Series, unit: str, where: str) -> FloatArray:
    """Return a column as numbers in the contract's unit, checked; no unit means the contract's."""
    numbers = pd.to_numeric(values, errors="coerce").to_numpy(dtype=np.float64)
    bad = ~np.isfinite(numbers)
    if bad.any():
        row = int(np.argmax(bad))
        raise InputError(
            f"{where}: column {str(values.name)!r}, row {row}: {values.iloc[row]!r}; allowed: a finite number"
        )
    unit = _UNIT_NAMES.get(unit.strip("[] "), unit.strip("[] "))
    if name in EXTRAS:
        table = EXTRAS[name]
        if unit and table and unit not in table:
            raise unknown_name(f"unit of {name!r}", unit, table, where)
        numbers = numbers * (table.get(unit, 1.0) if unit else 1.0)
        if name == "area" and (numbers < 0.0).any():
            raise InputError(f"{where}: column {str(values.name)!r}: an area below 0; allowed: 0 and more")
        return numbers
    quantity = QUANTITIES[name]
    if unit and unit != quantity.unit:
        if name == MU.name:
            raise unknown_name("unit of 'mu'", unit, ["1"], where)
        factor, offset = load_conversion(name, unit, where)  # contract -> unit
        numbers = (numbers - offset) / factor
    if name == "sigma_n":
        numbers = np.maximum(numbers, 0.0)  # codes write tension or a residue at points that do not touch
    if name == "v_rel":
        numbers = np.abs(numbers)
    outside = (numbers < quantity.lower) | (numbers > quantity.upper)
    if outside.any():
        row = int(np.argmax(outside))
        raise InputError(
            f"{where}: column {str(values.name)!r}, row {row}: {name} = {numbers[row]:g} {quantity.unit}; "
            f"allowed: {quantity.lower:g} to {quantity.upper:g} {quantity.unit}"
        )
    return numbers


def _durations(t: FloatArray, point: FloatArray | None) -> FloatArray:
    """Return how long each row stands for: half of the time to both neighbours of the same point."""
    times = np.unique(t)
    if len(times) < 2:
        return np.ones(len(t))
    if point is None:
        width = np.gradient(times)
        return np.asarray(width[np.searchsorted(times, t)])
    order = np.lexsort((t, point))
    gaps = np.where(np.diff(point[order]) == 0, np.diff(t[order]), 0.0)
    widths = np.empty(len(t))
    widths[order] = 0.5 * (np.r_[gaps, 0.0] + np.r_[0.0, gaps])
    return np.where(widths > 0.0, widths, float(np.median(np.diff(times))) / 2.0)
