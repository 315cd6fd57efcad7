"""TDMS files of LabVIEW and DIAdem, read with npTDMS."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common import InputError

from .formats import library
from .table import MAX_COLUMNS, RawTable, Signal, check_shape, is_time, split_unit, table_of_signals, text_of

_UNITS = ("unit_string", "NI_UnitDescription", "Unit", "unit", "units")


def read_tdms(file: Path) -> RawTable:
    """Read all channels that hold numbers; time is a channel of the group or the waveform's step.

    Raises InputError: damaged, more values than the file has bytes for, or nothing that holds numbers.
    """
    nptdms = library("nptdms", "npTDMS", file, "TDMS")
    notes: list[str] = []
    signals: list[Signal] = []
    with nptdms.TdmsFile.open(str(file)) as tdms:
        groups = tdms.groups()
        count = sum(len(group.channels()) for group in groups)
        if count > MAX_COLUMNS:
            raise InputError(f"{file}: {count} channels; allowed: at most {MAX_COLUMNS}")
        total = sum(len(channel) for group in groups for channel in group.channels())
        if total > file.stat().st_size:
            # Every value takes a byte at least.
            raise InputError(
                f"{file}: announces {total} values in {file.stat().st_size} bytes; it is damaged"
            )
        for group in groups:
            found = []
            for channel in group.channels():
                name = text_of(channel.name)
                check_shape(len(channel), 1, f"{file}: channel {name!r}")
                values = np.asarray(channel[:])
                if values.ndim != 1 or values.dtype.kind not in "fiub" or not len(values):
                    notes.append(f"channel {name!r} holds no numbers: left out")
                    continue
                name, unit = split_unit(name)
                unit = next((text_of(channel.properties[k]) for k in _UNITS if k in channel.properties), unit)
                found.append(Signal(name, unit, values, _waveform(channel, len(values)), text_of(group.name)))
            clock = next((signal for signal in found if is_time(signal.name)), None)
            if clock is not None:
                found = [signal for signal in found if signal is not clock] or [clock]
            for signal in found:
                if clock is not None and clock is not signal and len(clock.values) == len(signal.values):
                    signal.time, signal.time_name = clock.values, clock.name
                    signal.time_unit = clock.unit
            signals += found
    return table_of_signals(signals, str(file), "TDMS", notes)


def _waveform(channel: Any, rows: int) -> np.ndarray | None:
    step, start = channel.properties.get("wf_increment"), channel.properties.get("wf_start_offset", 0.0)
    if not isinstance(step, int | float) or not isinstance(start, int | float) or not 0.0 < step < 1e6:
        return None
    return float(start) + float(step) * np.arange(rows)
