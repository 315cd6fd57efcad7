"""MDF 3 and 4 (``.mf4``, ``.mdf``), read with asammdf."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from friction_models.common import InputError

from .formats import library
from .table import MAX_COLUMNS, RawTable, Signal, check_shape, table_of_signals, text_of

#: Conversions given as a formula are text that a library evaluates: such channels are left out.
_FORMULA = {3: (10,), 4: (3,)}


def read_mdf(file: Path) -> RawTable:
    """Read all channels that hold numbers; each channel group has its own master (time) channel.

    Raises InputError: not finalised, damaged, too large, or nothing that holds numbers.
    """
    with file.open("rb") as stream:
        head = stream.read(8)
    if head.startswith(b"UnFin"):
        raise InputError(f"{file}: an MDF file that was never finalised; allowed: a finished recording")
    asammdf = library("asammdf", "asammdf", file, "MDF")
    notes: list[str] = []
    signals: list[Signal] = []
    with asammdf.MDF(str(file)) as mdf:
        formula = _FORMULA[3 if str(mdf.version) < "4" else 4]
        count = sum(len(group.channels) for group in mdf.groups)
        if count > MAX_COLUMNS:
            raise InputError(f"{file}: {count} channels; allowed: at most {MAX_COLUMNS}")
        cells = 0
        for index, group in enumerate(mdf.groups):
            rows = int(getattr(group.channel_group, "cycles_nr", 0))
            cells += rows * len(group.channels)
            check_shape(rows, 1, f"{file}: channel group {index}")
            check_shape(max(rows, 1), -(-cells // max(rows, 1)), str(file))
            master = mdf.masters_db.get(index)
            for number, channel in enumerate(group.channels):
                if number == master:
                    continue
                name = text_of(channel.name) or f"channel {index}.{number}"
                kind = getattr(channel.conversion, "conversion_type", None)
                if kind in formula:
                    notes.append(f"channel {name!r} is converted by a formula: left out")
                    continue
                signal = mdf.get(group=index, index=number)
                samples = np.asarray(signal.samples)
                if samples.ndim != 1 or samples.dtype.kind not in "fiub" or samples.dtype.itemsize > 8:
                    notes.append(f"channel {name!r} holds no plain numbers: left out")
                    continue
                unit, place = text_of(signal.unit or ""), f"group {index}"
                if master is None:
                    signals.append(Signal(name, unit, samples, group=place))
                else:
                    time = np.asarray(signal.timestamps, np.float64)
                    clock = text_of(group.channels[master].name) or "t"
                    signals.append(Signal(name, unit, samples, time, place, clock))
    return table_of_signals(signals, str(file), "MDF", notes)
