"""Measurement files in every format that the readers read, written for the tests.

Each writer takes (path, frame, units); the frame has a column ``t`` with the time.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

Writer = Callable[[Path, pd.DataFrame, Mapping[str, str]], None]


def write_plain(
    path: Path, frame: pd.DataFrame, units: Mapping[str, str], sep: str = ",", decimal: str = "."
) -> None:
    lines = sep.join(frame.columns) + "\n" + sep.join(units[name] for name in frame.columns) + "\n"
    body = frame.to_csv(index=False, header=False, sep=sep, decimal=decimal, lineterminator="\n")
    path.write_text(lines + body, encoding="utf-8", newline="")


def write_catman_ascii(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    """Seven lines on the file, 29 lines on the channels, decimal comma, tabs, Windows-1252."""
    count = len(frame.columns)
    top = [
        "catman Prüfung",
        "Datei: x",
        "Datum: 1.1.2026",
        "Zeit: 12:00",
        "Kanäle: 3",
        "",
        f"Länge:   {len(frame)}",
    ]
    head = ["\t".join(frame.columns), "\t".join(units[name] for name in frame.columns)]
    head += ["\t".join(["0"] * count)] * 4 + ["\t".join([f"Zeile {k}"] * count) for k in range(23)]
    body = frame.to_csv(index=False, header=False, sep="\t", decimal=",", lineterminator="\r\n")
    text = "\r\n".join([*top, "", *head, ""]) + "\r\n" + body
    path.write_bytes(text.encode("cp1252"))


def write_catman(
    path: Path, frame: pd.DataFrame, units: Mapping[str, str], form: int = 0, version: int = 5012
) -> None:
    """A catman binary file; `form` 0, 1, 2 for doubles, singles and scaled 16-bit numbers."""

    def text(content: str, code: str = "h") -> bytes:
        raw = content.encode("cp1252")
        return struct.pack("<" + code, len(raw)) + raw

    def build(offset: int) -> bytes:
        out = struct.pack("<hi", version, offset) + text("made by a test")
        if version >= 5011:
            out += text("reserved") * 32
        out += (
            struct.pack("<hi", len(frame.columns), 0) + bytes(4 * len(frame.columns)) + struct.pack("<i", 0)
        )
        for number, name in enumerate(frame.columns):
            out += struct.pack("<hi", number + 1, len(frame)) + text(name) + text(units[name]) + text("")
            out += struct.pack("<hhd", 0, 8, 45000.0)
            extended = bytearray(148)
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
    from asammdf import MDF, Signal

    with MDF(version="4.10") as mdf:
        time = frame["t"].to_numpy()
        mdf.append(
            [Signal(frame[n].to_numpy(), time, name=n, unit=units[n]) for n in frame.columns if n != "t"]
        )
        mdf.save(path, overwrite=True)


def write_tdms(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(str(path)) as writer:
        writer.write_segment(
            [ChannelObject("rig", n, frame[n].to_numpy(), {"unit_string": units[n]}) for n in frame.columns]
        )


def write_matlab(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    from scipy.io import savemat

    savemat(
        path, {**{n: frame[n].to_numpy() for n in frame.columns}, "units": dict(units)}, do_compression=True
    )


def write_parquet(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    frame.rename(columns={n: f"{n} [{units[n]}]" for n in frame.columns}).to_parquet(path, index=False)


def write_excel(path: Path, frame: pd.DataFrame, units: Mapping[str, str]) -> None:
    from openpyxl import Workbook

    book = Workbook(write_only=True)
    sheet = book.create_sheet("test")
    sheet.append(["made by a test"])
    sheet.append(list(frame.columns))
    sheet.append([units[n] for n in frame.columns])
    for row in frame.itertuples(index=False):
        sheet.append(list(row))
    book.save(path)


WRITERS: dict[str, Writer] = {
    "comma": write_plain,
    "semicolon": lambda p, f, u: write_plain(p, f, u, ";", ","),
    "tab": lambda p, f, u: write_plain(p, f, u, "\t", ","),
    "catman ASCII": write_catman_ascii,
    "catman": write_catman,
    "catman 4 bytes": lambda p, f, u: write_catman(p, f, u, 1),
    "catman 2 bytes": lambda p, f, u: write_catman(p, f, u, 2),
    "catman 4.5": lambda p, f, u: write_catman(p, f, u, 0, 5010),
    "MDF": write_mdf,
    "TDMS": write_tdms,
    "MATLAB": write_matlab,
    "Parquet": write_parquet,
    "Excel": write_excel,
}
SUFFIX = {
    "comma": ".csv",
    "semicolon": ".csv",
    "tab": ".txt",
    "catman ASCII": ".asc",
    **{
        name: ".bin"
        for name in WRITERS
        if name in {"catman", "catman 4 bytes", "catman 2 bytes", "catman 4.5"}
    },
    "MDF": ".mf4",
    "TDMS": ".tdms",
    "MATLAB": ".mat",
    "Parquet": ".parquet",
    "Excel": ".xlsx",
}
