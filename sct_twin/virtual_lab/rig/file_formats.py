"""File formats of the virtual rig: column names, units and signs, and the channel map that reads them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from friction_models.common import unknown_name
from friction_models.common.units import conversion

from ...records.channels import CHANNELS
from . import file_writers as writers
from .instruments import RECORDED

#: What a logger resolves, in canonical units.
DIGITS = dict(zip(RECORDED, (6, 1, 2, 5, 1, 3)))


@dataclass(frozen=True)
class LoggedColumn:
    """How a channel stands in a file: its name there, the unit, and the sign that turns it right."""

    name: str
    unit: str
    sign: int = 1


@dataclass(frozen=True)
class FileFormat:
    """A kind of file."""

    #: ``--format`` name, end of the file names, what it is.
    name: str
    suffix: str
    meaning: str
    #: Canonical channel and its column.
    columns: Mapping[str, LoggedColumn]
    write: writers.Writer

    def save(self, path: Path, frame: pd.DataFrame) -> None:
        """Write a test in canonical channels and units as the logger would."""
        table: dict[str, object] = {}
        for channel, column in self.columns.items():
            values = frame[channel].to_numpy(float).round(DIGITS[channel])
            factor, offset = conversion(CHANNELS[channel].unit, column.unit, column.name)
            values = column.sign * (values - offset) / factor
            if offset:
                values = values.round(DIGITS[channel])
            # Divided by a power of ten: as many digits as before, not what the division leaves behind.
            table[column.name] = values.round(9)
        self.write(path, pd.DataFrame(table), {c.name: c.unit for c in self.columns.values()})

    def channel_map(self, moving_mass: float) -> str:
        """Return the text of the `channels.yaml` that `ingest` needs for these files."""
        lines = [
            f"# Files of the virtual rig ({writers.REMARK}): {self.meaning}.",
            "# Which column is which channel; units stand in the files.",
            "channels:",
        ]
        for channel, column in self.columns.items():
            sign = f", sign: {column.sign}" if column.sign < 0 else ""
            lines.append(f"  {column.name!r}: {{quantity: {channel}{sign}}}")
        return "\n".join([*lines, f"moving_mass: {moving_mass:g}  # kg", ""])


def _columns(**columns: tuple[str, str] | tuple[str, str, int]) -> dict[str, LoggedColumn]:
    return {channel: LoggedColumn(*columns[channel]) for channel in RECORDED}


_GERMAN = _columns(
    t=("Zeit", "s"),
    F_n=("Normalkraft", "kN"),
    F_r=("Reibkraft", "kN"),
    s=("Plattenweg", "mm"),
    a=("Beschleunigung", "m/s2"),
    T_plate=("Plattentemperatur", "°C"),
)
_CATMAN = _columns(
    t=("Zeit  1 - Standardmessrate", "s"),
    F_n=("Kraft Z", "kN", -1),
    F_r=("Kraft X", "kN"),
    s=("Weg Platte", "mm"),
    a=("Beschl X", "m/s2"),
    T_plate=("Temp Platte", "°C"),
)
_ENGLISH = _columns(
    t=("time", "s"),
    F_n=("NormalForce", "N"),
    F_r=("FrictionForce", "N"),
    s=("PlatePosition", "mm"),
    a=("PlateAcceleration", "m/s2"),
    T_plate=("PlateTemperature", "degC"),
)
_LABVIEW = _columns(
    t=("Time", "s"),
    F_n=("Fz", "N", -1),
    F_r=("Fx", "N"),
    s=("Position", "mm"),
    a=("Accel", "g"),
    T_plate=("TC plate", "K"),
)
_SHORT = _columns(
    t=("t", "s"),
    F_n=("Fn", "kN"),
    F_r=("Fr", "kN"),
    s=("x_plate", "mm"),
    a=("a_plate", "m/s2"),
    T_plate=("T_plate", "degC"),
)
CANONICAL = _columns(**{channel: (channel, CHANNELS[channel].unit) for channel in RECORDED})

FORMATS: dict[str, FileFormat] = {
    f.name: f
    for f in (
        FileFormat("canonical", ".csv", "the project's own CSV", CANONICAL, writers.write_plain),
        FileFormat(
            "csv",
            ".csv",
            "semicolons, decimal comma, a units row",
            _GERMAN,
            lambda p, f, u: writers.write_plain(p, f, u, ";", ","),
        ),
        FileFormat(
            "ascii",
            ".asc",
            "catman ASCII: tabs, decimal comma, Windows-1252",
            _CATMAN,
            writers.write_catman_ascii,
        ),
        FileFormat("catman", ".bin", "catman binary, file version 5012", _CATMAN, writers.write_catman),
        FileFormat("mdf", ".mf4", "MDF 4.10", _ENGLISH, writers.write_mdf),
        FileFormat("tdms", ".tdms", "TDMS of LabVIEW", _LABVIEW, writers.write_tdms),
        FileFormat("mat", ".mat", "MATLAB 5", _SHORT, writers.write_matlab),
        FileFormat("parquet", ".parquet", "Parquet", _ENGLISH, writers.write_parquet),
        FileFormat("xlsx", ".xlsx", "an Excel sheet", _GERMAN, writers.write_excel),
    )
}


def file_format(name: str) -> FileFormat:
    """Return a format. Raises InputError: not one of `FORMATS`."""
    if name not in FORMATS:
        raise unknown_name("file format", name, FORMATS)
    return FORMATS[name]
