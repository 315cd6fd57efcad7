"""Measurement files in every format that the readers read, in all their variants, written for the tests.

Each writer takes (path, frame, units); the frame has a column ``t`` with the time.
"""

from __future__ import annotations

from sct_twin.virtual_lab.rig.file_writers import (
    Writer,
    write_catman,
    write_catman_ascii,
    write_excel,
    write_matlab,
    write_mdf,
    write_parquet,
    write_plain,
    write_tdms,
)

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
