"""Binary files of catman (HBK): a header, a header for each channel, then the channels one by one.

The layout is not published as a standard; this reader follows what the maker's help describes for file
versions 5010 and later and is checked against the independent package apread in the tests.
"""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import BinaryIO

import numpy as np

from friction_models.common import InputError

from .table import MAX_COLUMNS, RawTable, Signal, check_shape, is_time, table_of_signals, text_of

_RESERVED = 32
#: Bytes of the extended channel header up to the byte that says how numbers are stored, and its place.
_EXPORT_FORMAT = 140
_WIDTH = {0: 8, 1: 4, 2: 2}


class _Stream:
    """Little-endian fields of a file, each checked against the bytes that are left."""

    def __init__(self, stream: BinaryIO, size: int, where: str) -> None:
        self.stream, self.size, self.where = stream, size, where

    def take(self, count: int, what: str) -> bytes:
        if count < 0 or count > self.size - self.stream.tell():
            raise InputError(
                f"{self.where}: {what} needs {count} bytes, {self.size - self.stream.tell()} are left; "
                "the file looks truncated"
            )
        return self.stream.read(count)

    def number(self, code: str, what: str) -> float | int:
        value: float | int = struct.unpack("<" + code, self.take(struct.calcsize("<" + code), what))[0]
        return value

    def text(self, what: str, length: str = "h") -> str:
        raw = self.take(int(self.number(length, what)), what)
        try:
            return text_of(raw.decode("utf-8"))
        except UnicodeDecodeError:
            return text_of(raw.decode("cp1252", "replace"))


def looks_like_catman(head: bytes) -> bool:
    """Whether a file begins with a file version that catman writes."""
    return len(head) >= 6 and 5000 <= struct.unpack("<h", head[:2])[0] <= 5099


def read_catman(path: str | os.PathLike[str]) -> RawTable:
    """Read a catman `.bin` file; channels without a time channel take time from their step.

    Raises
    ------
    InputError
        Not such a file, an older version, truncated, or counts that the file cannot hold.
    """
    file = Path(path)
    where = str(file)
    with file.open("rb") as raw:
        stream = _Stream(raw, file.stat().st_size, where)
        version = int(stream.number("h", "file version"))
        if not 5010 <= version <= 5099:
            raise InputError(f"{where}: catman file version {version}; allowed: 5010 to 5099")
        offset = int(stream.number("i", "place of the data"))
        stream.text("comment")
        # Version 4.5 (5010) has no reserved texts, and nothing on the sensor up to 5011.
        for _ in range(_RESERVED if version >= 5011 else 0):
            stream.text("reserved text")
        count = int(stream.number("h", "number of channels"))
        if not 1 <= count <= MAX_COLUMNS:
            raise InputError(f"{where}: {count} channels; allowed: 1 to {MAX_COLUMNS}")
        stream.number("i", "largest length")
        stream.take(4 * count, "table of channels")
        stream.number("i", "reduction")
        heads = [_channel(stream, number, version) for number in range(count)]
        if not raw.tell() <= offset <= stream.size:
            raise InputError(
                f"{where}: the data begins at byte {offset}; allowed: {raw.tell()} to {stream.size}"
            )
        raw.seek(offset)
        signals: list[Signal] = []
        steps: dict[int, float] = {}
        notes: list[str] = []
        for name, unit, rows, kind, width, step in heads:
            if rows == 0:
                notes.append(f"channel {name!r} is empty: left out")
                continue
            if kind != 0:
                # Text and binary channels say how many bytes a value has; they are passed over.
                stream.take(rows * width, f"channel {name!r}")
                notes.append(f"channel {name!r} holds no numbers: left out")
                continue
            signals.append(Signal(name, unit, _values(stream, name, rows, width)))
            steps.setdefault(rows, step)
    return table_of_signals(_timed(signals, steps), where, "catman", notes)


def _channel(stream: _Stream, number: int, version: int) -> tuple[str, str, int, int, int, float]:
    """Return name, unit, rows, kind, bytes a value and time step of a channel header."""
    what = f"header of channel {number + 1}"
    stream.number("h", what)
    rows = int(stream.number("i", what))
    check_shape(rows, 1, f"{stream.where}: {what}")
    name = stream.text(what) or f"channel {number + 1}"
    unit = stream.text(what)
    stream.text(what)
    kind = int(stream.number("h", what))
    width = int(stream.number("h", what))
    stream.number("d", what)
    extended = stream.take(int(stream.number("i", what)), what)
    step, form = 0.0, 0
    if len(extended) > _EXPORT_FORMAT:
        step = float(struct.unpack_from("<d", extended, 8)[0])
        form = extended[_EXPORT_FORMAT]
    stream.take(2, what)
    stream.take(8 * int(stream.number("B", what)), what)
    stream.take(2, what)
    stream.text(what)
    if version >= 5012:
        stream.text(what, "i")
    if kind == 0:
        if form not in _WIDTH:
            raise InputError(
                f"{stream.where}: channel {name!r} stores numbers as kind {form}; allowed: 0, 1, 2"
            )
        width = _WIDTH[form]
    return name, unit, rows, kind, width, step


def _values(stream: _Stream, name: str, rows: int, width: int) -> np.ndarray:
    what = f"channel {name!r}"
    if width != 2:
        return np.frombuffer(stream.take(rows * width, what), f"<f{width}").astype(np.float64)
    low, high = float(stream.number("d", what)), float(stream.number("d", what))
    if not (np.isfinite(low) and np.isfinite(high)):
        raise InputError(f"{stream.where}: {what} is scaled from {low} to {high}; allowed: finite numbers")
    with np.errstate(over="ignore"):
        return np.frombuffer(stream.take(2 * rows, what), "<u2") * ((high - low) / 32767.0) + low


def _timed(signals: list[Signal], steps: dict[int, float]) -> list[Signal]:
    """Give every channel the time channel of its length, or one made of its step."""
    clocks = {len(signal.values): signal for signal in reversed(signals) if is_time(signal.name)}
    timed = []
    for signal in signals:
        rows = len(signal.values)
        clock = clocks.get(rows)
        if clock is signal:
            if sum(len(s.values) == rows for s in signals) == 1:
                timed.append(signal)
            continue
        if clock is not None:
            signal.time, signal.time_name, signal.time_unit = clock.values, clock.name, clock.unit or "s"
        elif np.isfinite(steps[rows]) and 0.0 < steps[rows] < 1e6:
            # The step of the extended header is in milliseconds.
            signal.time = np.arange(rows) * (steps[rows] * 1e-3)
        timed.append(signal)
    return timed
