"""Measurement files as data loggers write them: text, catman, MDF, TDMS, MATLAB, Parquet, Excel.

Each writer takes (path, frame, units); the frame has the time in its first column. They write what the
readers of `sct_twin.readers` read and are used by the virtual rig only: a virtual laboratory has to hand
out files of the kind that a real one does.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

Writer = Callable[[Path, pd.DataFrame, Mapping[str, str]], None]

#: What stands in every file of the virtual rig that has room for a remark.
REMARK = "synthetic: virtual laboratory, not measured"
#: Lines that catman ASCII exports hold between the units and the numbers.
_CATMAN_LINES = 27


def write_plain(
    path: Path, frame: pd.DataFrame, units: Mapping[str, str], sep: str = ",", decimal: str = "."
) -> None:
    """Write text: names, units, numbers, in UTF-8."""
    names = sep.join(map(str, frame.columns)) + "\n" + sep.join(units[name] for name in frame.columns) + "\n"
    path.write_bytes(names.encode() + _numbers(frame, sep, decimal, "\n"))


def write_catman_ascii(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    """Write text as catman does: lines on the file, lines on the channels, tabs, decimal comma, Windows-1252."""
    count = len(frame.columns)
    top = [
        "catman Messdaten",
        f"Kommentar: {REMARK}",
        "Datum: 1.1.2026",
        "Zeit: 12:00",
        f"Kanäle: {count}",
        "",
        f"Länge:   {len(frame)}",
    ]
    head = ["\t".join(map(str, frame.columns)), "\t".join(units[name] for name in frame.columns)]
    head += ["\t".join(["0"] * count)] * 4
    head += ["\t".join([f"Zeile {k}"] * count) for k in range(_CATMAN_LINES - 4)]
    text = "\r\n".join([*top, "", *head, ""]) + "\r\n"
    path.write_bytes(text.encode("cp1252") + _numbers(frame, "\t", ",", "\r\n"))


def write_catman(
    path: Path, frame: pd.DataFrame, units: Mapping[str, str], form: int = 0, version: int = 5012
) -> None:
    """Write a catman binary file; `form` 0, 1, 2 for doubles, singles and scaled 16-bit numbers.

    The layout is the one that `sct_twin.readers.catman` reads; it is not a published standard.
    """

    def text(content: str, code: str = "h") -> bytes:
        raw = content.encode("cp1252")
        return struct.pack("<" + code, len(raw)) + raw

    def build(offset: int) -> bytes:
        out = struct.pack("<hi", version, offset) + text(REMARK)
        if version >= 5011:
            out += text("reserved") * 32
        out += (
            struct.pack("<hi", len(frame.columns), 0) + bytes(4 * len(frame.columns)) + struct.pack("<i", 0)
        )
        for number, name in enumerate(map(str, frame.columns)):
            out += struct.pack("<hi", number + 1, len(frame)) + text(name) + text(units[name]) + text("")
            out += struct.pack("<hhd", 0, 8, 45000.0)
            extended = bytearray(148)
            # Date and time step [ms], then how numbers are stored.
            struct.pack_into("<dd", extended, 0, 45000.0, 1.0)
            extended[140] = form
            out += struct.pack("<i", 148) + bytes(extended) + b"\0\0\0" + struct.pack("<h", 0) + text("")
            if version >= 5012:
                out += text("", "i")
        return out

    content = build(len(build(0)))
    for name in frame.columns:
        values = frame[name].to_numpy(np.float64)
        if form < 2:
            content += values.astype("<f8" if form == 0 else "<f4").tobytes()
        else:
            low, high = float(values.min()), float(values.max())
            steps = np.round((values - low) / ((high - low) / 32767 or 1.0)).astype("<u2")
            content += struct.pack("<dd", low, high) + steps.tobytes()
    path.write_bytes(content)


def write_mdf(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    """Write MDF 4.10 with one group; its master channel is called ``time``."""
    from asammdf import MDF, Signal

    clock, *others = map(str, frame.columns)
    time = frame[clock].to_numpy()
    with MDF(version="4.10") as mdf:
        mdf.append([Signal(frame[n].to_numpy(), time, name=n, unit=units[n]) for n in others], comment=REMARK)
        mdf.save(path, overwrite=True)


def write_tdms(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    """Write one TDMS group; units as LabVIEW stores them."""
    from nptdms import ChannelObject, RootObject, TdmsWriter

    channels = [
        ChannelObject("rig", str(n), frame[n].to_numpy(), {"unit_string": units[n]}) for n in frame.columns
    ]
    with TdmsWriter(str(path)) as writer:
        writer.write_segment([RootObject({"comment": REMARK}), *channels])


def write_matlab(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    """Write MATLAB 5: a vector a channel, and a struct of units."""
    from scipy.io import savemat

    vectors = {str(n): frame[n].to_numpy() for n in frame.columns}
    savemat(path, {**vectors, "units": {n: units[n] for n in vectors}}, do_compression=True)


def write_parquet(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    """Write Parquet with columns ``name [unit]``."""
    named = frame.rename(columns={n: f"{n} [{units[n]}]" for n in frame.columns})
    named.to_parquet(path, index=False)


def write_excel(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    """Write a sheet with a line above the table, names, units and numbers."""
    from openpyxl import Workbook

    book = Workbook(write_only=True)
    sheet = book.create_sheet("test")
    sheet.append([REMARK])
    sheet.append(list(map(str, frame.columns)))
    sheet.append([units[n] for n in frame.columns])
    for row in frame.itertuples(index=False):
        sheet.append(list(row))
    book.save(path)


def _numbers(frame: pd.DataFrame, sep: str, decimal: str, newline: str) -> bytes:
    """Return the rows as text; numbers as short as they are exact."""
    columns: Sequence[list[str]] = [list(map(repr, frame[n].to_numpy(np.float64).tolist())) for n in frame]
    body = newline.join(map(sep.join, zip(*columns))) + newline
    return (body if decimal == "." else body.replace(".", decimal)).encode()
