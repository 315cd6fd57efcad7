"""Force-stroke records of a press: a folder with `levels.csv` and one CSV of curves for each factor level."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from friction_models.common import InputError, atomic_folder, unknown_name, write_json
from friction_models.common.files import read_json
from friction_models.common.folders import PRESS
from friction_models.loads import Quantity, check_column, missing_column
from friction_models.loads.table import KNOWN_UNITS, read_file

from .fe.mesh.shape import FloatArray

STROKE = Quantity("stroke", "mm", "punch travel", -1.0, 1e4, 10.0)
FORCE = Quantity("force", "kN", "punch force", -1e3, 1e5, 300.0)
LEVEL_COLUMNS = ("process", "T_tool", "speed", "lubricant", "file")
#: Forward rod and backward cup extrusion.
PRESS_PROCESSES = ("fre", "bce")
#: Units of the columns that are known.
UNITS = {**KNOWN_UNITS, STROKE.name: STROKE.unit, FORCE.name: FORCE.unit}
_LEVEL_LIMITS = (
    Quantity("T_tool", "degC", "tool temperature", -273.15, 2000.0, 20.0),
    Quantity("speed", "mm/s", "punch speed", 1e-3, 1e5, 5.0),
)
#: Largest file that is read.
MAX_BYTES = 512 * 1024**2


@dataclass(frozen=True)
class PressLevel:
    """One factor level: how it was formed, and its curves.

    Attributes
    ----------
    process : str
        ``"fre"`` or ``"bce"``.
    T_tool : float
        Tool temperature [degC].
    speed : float
        Punch speed [mm/s].
    lubricant : str
        Name.
    file : str
        Name of the level's CSV in the folder.
    curves : pandas.DataFrame
        Columns stroke [mm], force [kN], repeat; stroke does not run backwards within a repeat.
    synthetic : bool
        Computed, not measured.

    Examples
    --------
    Two repeats in which the force rises along a straight line, to 100 and 104 kN over 10 mm:

    >>> from forming import PressLevel
    >>> curves = pd.DataFrame({"stroke": [0.0, 10.0] * 2, "force": [0.0, 100.0, 0.0, 104.0], "repeat": [1, 1, 2, 2]})
    >>> level = PressLevel("fre", 20.0, 5.0, "soap", "soap.csv", curves)
    >>> level.max_forces().tolist()
    [100.0, 104.0]
    >>> level.works().tolist()
    [500.0, 520.0]
    >>> level.on_grid([5.0, 12.0]).tolist()
    [[50.0, nan], [52.0, nan]]
    """

    process: str
    T_tool: float
    speed: float
    lubricant: str
    file: str
    curves: pd.DataFrame = field(repr=False)
    synthetic: bool = False

    @property
    def repeats(self) -> list[pd.DataFrame]:
        """The curves one by one."""
        return [curve.reset_index(drop=True) for _, curve in self.curves.groupby("repeat", sort=True)]

    def on_grid(self, stroke: npt.ArrayLike) -> FloatArray:
        """Return the forces of every repeat at the given strokes, shape (n_repeats, n) [kN]; NaN beyond a record."""
        at = np.asarray(stroke, dtype=np.float64)
        return np.array(
            [np.interp(at, c["stroke"], c["force"], left=np.nan, right=np.nan) for c in self.repeats]
        )

    def max_forces(self) -> FloatArray:
        """Return the highest force of each repeat [kN]."""
        return np.array([float(c["force"].max()) for c in self.repeats])

    def works(self) -> FloatArray:
        """Return the forming work of each repeat [J] (kN mm)."""
        return np.array([float(np.trapezoid(c["force"], c["stroke"])) for c in self.repeats])


@dataclass(frozen=True)
class PressCurves:
    """The records of a press campaign.

    Attributes
    ----------
    levels : tuple of PressLevel
        Factor levels.
    info : dict
        Content of `press.json`: provenance.

    Examples
    --------
    >>> import tempfile
    >>> from forming import PressCurves, PressLevel
    >>> curves = pd.DataFrame({"stroke": [0.0, 10.0], "force": [0.0, 100.0], "repeat": [1, 1]})
    >>> campaign = PressCurves((PressLevel("fre", 20.0, 5.0, "soap", "soap.csv", curves, synthetic=True),))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     again = PressCurves.read(campaign.save(Path(folder) / "press"))
    >>> again.synthetic, again.levels[0].lubricant, again.levels[0].max_forces().tolist()
    (True, 'soap', [100.0])
    """

    levels: tuple[PressLevel, ...]
    info: dict[str, Any] = field(default_factory=dict)

    @property
    def synthetic(self) -> bool:
        """Whether any level was computed instead of measured."""
        return any(level.synthetic for level in self.levels)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> PressCurves:
        """Read a folder of press curves.

        Raises
        ------
        InputError
            A file or column is missing, a value is not a number or outside its limits, a unit does not
            fit, or stroke runs backwards; the message names the file and the row (counted from 0).
        """
        folder = Path(path)
        table = folder / "levels.csv"
        if not table.is_file():
            raise InputError(f"{folder}: no levels.csv; allowed: a folder of press curves")
        frame = _table(table)
        for column in LEVEL_COLUMNS:
            if column not in frame.columns:
                raise missing_column(column, frame.columns, str(table))
        numbers = {q.name: check_column(frame[q.name].to_numpy(), q, str(table)) for q in _LEVEL_LIMITS}
        twice = frame.duplicated(["file"])
        if twice.any():
            row = int(np.argmax(twice))
            raise InputError(
                f"{table}: row {row}: file {frame['file'].iloc[row]!r} stands above already; allowed: a file for each level"
            )
        levels = []
        for row, entry in enumerate(frame.to_dict("records")):
            process = str(entry["process"]).strip().lower()
            if process not in PRESS_PROCESSES:
                raise unknown_name("process", entry["process"], PRESS_PROCESSES, f"{table}, row {row}")
            name = str(entry["file"]).strip()
            if not _stays_inside(name):
                raise InputError(
                    f"{table}: column 'file', row {row}: {name!r}; allowed: a path inside the folder"
                )
            T_tool, speed = (float(numbers[q.name][row]) for q in _LEVEL_LIMITS)
            curves = read_curves(folder / name)
            synthetic = _truth(entry.get("synthetic", False), table, row)
            levels.append(
                PressLevel(process, T_tool, speed, str(entry["lubricant"]), name, curves, synthetic)
            )
        about = folder / "press.json"
        return cls(tuple(levels), read_json(about) if about.is_file() else {})

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the folder, atomically; return its path."""
        rows = [{c: getattr(v, c) for c in (*LEVEL_COLUMNS, "synthetic")} for v in self.levels]
        with atomic_folder(path, PRESS) as folder:
            frame = pd.DataFrame(rows, columns=[*LEVEL_COLUMNS, "synthetic"])
            frame.to_csv(folder / "levels.csv", index=False, lineterminator="\n")
            for level in self.levels:
                if not _stays_inside(level.file):
                    raise InputError(f"press curves: file {level.file!r}; allowed: a path inside the folder")
                target = folder / level.file
                target.parent.mkdir(parents=True, exist_ok=True)
                header = {"stroke": "stroke [mm]", "force": "force [kN]"}
                table = level.curves[["stroke", "force", "repeat"]].rename(columns=header)
                table.to_csv(target, index=False, lineterminator="\n")
            write_json(folder / "press.json", {**self.info, "synthetic": self.synthetic})
        return Path(path)


def read_curves(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read the curves of one level; return stroke [mm], force [kN], repeat.

    Units stand in the header (``force [kN]``) or in a row below it; N, MN, m and cm are converted. A
    missing `repeat` column means one repeat.

    Raises InputError: see `PressCurves.read`.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "level.csv"
    ...     table = pd.DataFrame({"stroke [cm]": [0.0, 1.0], "force [N]": [0.0, 2500.0]})
    ...     table.to_csv(file, index=False)
    ...     curves = read_curves(file)
    >>> curves["stroke"].tolist(), curves["force"].tolist(), curves["repeat"].tolist()
    ([0.0, 10.0], [0.0, 2.5], [1, 1])
    """
    file = Path(path)
    frame = _table(file)
    columns: dict[str, npt.ArrayLike] = {}
    for quantity in (STROKE, FORCE):
        if quantity.name not in frame.columns:
            raise missing_column(quantity.name, frame.columns, str(file))
        columns[quantity.name] = check_column(frame[quantity.name].to_numpy(), quantity, str(file))
    repeat = frame["repeat"] if "repeat" in frame.columns else pd.Series(1, index=frame.index)
    if repeat.isna().any():
        row = int(np.argmax(repeat.isna()))
        raise InputError(f"{file}: column 'repeat', row {row}: no value; allowed: a name or number")
    curves = pd.DataFrame({**columns, "repeat": repeat.to_numpy()})
    before = curves["stroke"].groupby(curves["repeat"]).shift()
    backwards = curves["stroke"] < before
    if backwards.any():
        row = int(np.argmax(backwards))
        raise InputError(
            f"{file}: column 'stroke', row {row}: {curves['stroke'][row]:g} mm comes after "
            f"{before[row]:g} mm; stroke must not run backwards within a repeat"
        )
    return curves


def _table(file: Path) -> pd.DataFrame:
    """Return a table of levels or curves in the units of the contract."""
    return read_file(file, UNITS, MAX_BYTES).converted(UNITS)


def _stays_inside(name: str) -> bool:
    path = PurePosixPath(name.replace("\\", "/"))
    return bool(name) and not path.is_absolute() and ".." not in path.parts and ":" not in name


def _truth(value: object, table: Path, row: int) -> bool:
    """Return a Boolean cell."""
    text = str(value).strip().lower()
    if text in {"true", "1", "yes"}:
        return True
    if text in {"false", "0", "no", "nan", ""}:
        return False
    raise InputError(f"{table}: column 'synthetic', row {row}: {value!r}; allowed: true, false")
