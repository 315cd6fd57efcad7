"""Two recorded nets, file by file: archives by member, JSON by value, tables and time series by number, pages as text."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

#: Keys of JSON files whose values differ between two runs of the same code.
VOLATILE = re.compile(
    r"time|seconds|written|version|created|platform|duration|cpu|date|path|folder|machine|code|host", re.I
)
#: Text that differs between two runs of the same code: moments, durations, identifiers of figures, hashes of code.
MOMENTS = re.compile(
    rb"\d{4}-\d\d-\d\dT[\d:.+Z-]+|\d{4}-\d\d-\d\d \d\d:\d\d(:\d\d)?|[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}"
    rb"|\b\d+(\.\d+)? (ms|s|min)\b"
)
ARCHIVES = {".fmu", ".ssp", ".zip"}


def differences(old: Path, new: Path) -> Iterator[str]:
    """Yield a line for every difference between the files of two folders."""
    before, after = _files(old), _files(new)
    yield from (f"gone: {name}" for name in sorted(before.keys() - after.keys()))
    yield from (f"new: {name}" for name in sorted(after.keys() - before.keys()))
    for name in sorted(before.keys() & after.keys()):
        for line in _compared(name, before[name].read_bytes(), after[name].read_bytes()):
            yield f"{name}: {line}"


def _files(folder: Path) -> dict[str, Path]:
    found = (p for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts)
    return {p.relative_to(folder).as_posix(): p for p in found}


def _compared(name: str, old: bytes, new: bytes) -> Iterator[str]:
    if old == new:
        return
    suffix = Path(name).suffix
    if suffix in ARCHIVES:
        yield from _archives(old, new)
    elif suffix == ".json":
        yield from _values("", json.loads(old), json.loads(new))
    elif suffix == ".nc":
        yield from _series(old, new)
    elif suffix in {".npz", ".onnx", ".so", ".dll", ".dylib", ".parquet"}:
        yield f"{len(old)} and {len(new)} bytes differ"
    else:
        yield from _texts(old, new)


def _archives(old: bytes, new: bytes) -> Iterator[str]:
    with zipfile.ZipFile(io.BytesIO(old)) as one, zipfile.ZipFile(io.BytesIO(new)) as two:
        names = set(one.namelist()), set(two.namelist())
        yield from (f"member gone: {n}" for n in sorted(names[0] - names[1]))
        yield from (f"member new: {n}" for n in sorted(names[1] - names[0]))
        for member in sorted(names[0] & names[1]):
            yield from (f"{member}: {line}" for line in _compared(member, one.read(member), two.read(member)))


def _values(where: str, old: Any, new: Any) -> Iterator[str]:
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            if VOLATILE.search(key):
                continue
            if key not in old or key not in new:
                yield f"{where}/{key}: only {'before' if key in old else 'after'}"
            else:
                yield from _values(f"{where}/{key}", old[key], new[key])
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for k, (a, b) in enumerate(zip(old, new)):
            yield from _values(f"{where}[{k}]", a, b)
    elif old != new and not (old != old and new != new):
        same = isinstance(old, str) and isinstance(new, str) and _still(old.encode()) == _still(new.encode())
        if not same:
            yield f"{where}: {str(old)[:80]!r} -> {str(new)[:80]!r}"


def _series(old: bytes, new: bytes) -> Iterator[str]:
    import netCDF4

    with netCDF4.Dataset("old", memory=old) as one, netCDF4.Dataset("new", memory=new) as two:
        names = set(one.variables), set(two.variables)
        yield from (f"variable only on one side: {n}" for n in sorted(names[0] ^ names[1]))
        for name in sorted(names[0] & names[1]):
            a, b = np.asarray(one[name][:]), np.asarray(two[name][:])
            if a.shape != b.shape:
                yield f"{name}: shape {a.shape} -> {b.shape}"
            elif a.tobytes() != b.tobytes() and not np.array_equal(a, b):
                yield f"{name}: differs by up to {np.nanmax(np.abs(a - b)):g}"


def _still(text: bytes) -> bytes:
    return MOMENTS.sub(b"?", text)


def _texts(old: bytes, new: bytes) -> Iterator[str]:
    before, after = _still(old).splitlines(), _still(new).splitlines()
    if before == after:
        return
    if len(before) != len(after):
        yield f"{len(before)} -> {len(after)} lines"
    for k, (a, b) in enumerate(zip(before, after), 1):
        if a != b:
            at = next((i for i, (x, y) in enumerate(zip(a, b)) if x != y), min(len(a), len(b)))
            begin = max(0, at - 40)
            yield f"line {k}: {a[begin : at + 60]!r} -> {b[begin : at + 60]!r}"
            return
