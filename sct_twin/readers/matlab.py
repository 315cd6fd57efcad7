"""MATLAB files of version 5 to 7.2, read with scipy; 7.3 is HDF5 and refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common import InputError

from .table import MAX_CELLS, MAX_COLUMNS, RawTable, Signal, is_time, split_unit, table_of_signals, text_of

_VALUES = ("data", "values", "value", "signal", "y")
_UNITS = ("unit", "units")
_NAMES = ("names", "channels", "labels", "header", "columns")


def read_matlab(file: Path) -> RawTable:
    """Read vectors, structs of vectors or of ``data`` with ``unit``, and matrices with ``names``.

    A variable ``units`` (a struct with the channels' names, or a cell array beside ``names``) gives units.

    Raises InputError: version 7.3, damaged, too large, or no vectors of numbers.
    """
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import MatReadError

    with file.open("rb") as stream:
        head = stream.read(128)
    if head.startswith(b"\x89HDF") or b"MATLAB 7.3" in head or head[124:126] in (b"\x00\x02", b"\x02\x00"):
        raise InputError(
            f"{file}: MATLAB version 7.3 (HDF5) has no reader; allowed: version 5 to 7.2 (save with -v7)"
        )
    try:
        sizes = whosmat(str(file))
        cells = sum(int(np.prod([float(n) for n in shape])) for _, shape, _ in sizes)
        if cells > MAX_CELLS or len(sizes) > MAX_COLUMNS:
            raise InputError(f"{file}: {len(sizes)} variables with {cells} cells; allowed: {MAX_CELLS} cells")
        content = loadmat(str(file), squeeze_me=True, struct_as_record=True, chars_as_strings=True)
    except NotImplementedError:
        raise InputError(
            f"{file}: this MATLAB version has no reader; allowed: version 5 to 7.2 (save with -v7)"
        ) from None
    except MatReadError as error:
        raise InputError(f"{file}: not a readable MATLAB file ({' '.join(str(error).split())})") from None
    notes: list[str] = []
    signals: list[Signal] = []
    variables = {name: value for name, value in content.items() if not name.startswith("__")}
    _collect(variables, "", signals, notes)
    clocks = {len(signal.values): signal for signal in reversed(signals) if is_time(signal.name)}
    timed: list[Signal] = []
    for signal in signals:
        clock = clocks.get(len(signal.values))
        if clock is signal and len(signals) > 1:
            continue
        if clock is not None and clock is not signal:
            signal.time, signal.time_name, signal.time_unit = clock.values, clock.name, clock.unit
        timed.append(signal)
    return table_of_signals(timed, str(file), "MATLAB", notes)


def _collect(variables: dict[str, object], group: str, signals: list[Signal], notes: list[str]) -> None:
    """Take channels from variables or from the fields of a struct; one level of structs is looked into."""
    units = next((variables[n] for n in _UNITS if n in variables), None)
    names = next((_texts(variables[n]) for n in _NAMES if n in variables and _texts(variables[n])), [])
    for name, value in variables.items():
        if name in _UNITS or name in _NAMES:
            continue
        if not isinstance(value, np.ndarray):
            continue
        fields = value.dtype.names
        if fields and value.ndim == 0:
            inner = {field: _plain(value[field]) for field in fields}
            data = next((inner[k] for k in _VALUES if _is_vector(inner.get(k))), None)
            if data is not None:
                unit = next((_text(inner[k]) for k in _UNITS if k in inner), "")
                signals.append(Signal(name, unit, data, group=group))
            elif not group:
                _collect(inner, name, signals, notes)
            continue
        if _is_vector(value):
            plain, unit = split_unit(name)
            signals.append(Signal(plain, _unit_of(name, units, -1) or unit, value, group=group))
        elif value.ndim == 2 and value.dtype.kind in "fiu" and len(names) in value.shape:
            matrix = value if value.shape[1] == len(names) else value.T
            for column, heading in enumerate(names):
                plain, unit = split_unit(heading)
                unit = _unit_of(heading, units, column) or unit
                signals.append(Signal(plain, unit, np.ascontiguousarray(matrix[:, column]), group=group))
        else:
            notes.append(f"variable {name!r} is no vector of numbers: left out")


def _plain(value: Any) -> Any:
    """Unwrap what a struct holds in an array of objects."""
    if isinstance(value, np.ndarray) and value.dtype == object and value.ndim == 0:
        return value.item()
    return value


def _is_vector(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "fiub" and len(value) > 1


def _text(value: Any) -> str:
    # An empty text comes as an empty array.
    return "" if isinstance(value, np.ndarray) and value.size == 0 else text_of(value)


def _texts(value: Any) -> list[str]:
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "UO":
        return [_text(item) for item in value]
    return []


def _unit_of(name: str, units: Any, column: int) -> str:
    if isinstance(units, np.ndarray):
        if units.dtype.names and units.ndim == 0 and name in units.dtype.names:
            return _text(_plain(units[name]))
        if 0 <= column < len(texts := _texts(units)):
            return texts[column]
    return ""
