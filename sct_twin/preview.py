"""What measurement files hold and what a channel map makes of it, before anything is written."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from friction_models.loads import InputError

from .channel_map import ChannelMap
from .channels import CHANNELS
from .ingest import measurement_files
from .quality import quality_row
from .readers import SUFFIXES, RawTable, read_file
from .units import conversion

#: Names that laboratories give to their channels, tried in this order.
_NAMES: dict[str, str] = {
    "t": r"^(t|time|timestamps?|zeit)\b|\b(time|zeit)\b",
    "F_n": r"\b(f_?n|f_?z|normal|kraft[ _]?[zn]|load|axial)",
    "F_r": r"\b(f_?r|f_?t|f_?x|fric|reib|tang|kraft[ _]?x|shear)",
    "a": r"\b(a|acc\w*|beschl\w*)\b",
    "T_plate": r"\b(t_?plate|temp\w*|thermo\w*)",
    "s": r"\b(s|pos\w*|weg\w*|disp\w*|path|stroke|slide)\b",
}
#: So many files that cannot be read are tried before the preview gives up.
_TRIES = 5


def preview(
    source: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    channel_map: str | os.PathLike[str] | Mapping[str, Any] | None = None,
) -> str:
    """Return what was found: files by format, the columns of the first one, its phases; writes nothing.

    Where the map does not fit the columns, a draft of `channels.yaml` is added.

    Raises
    ------
    InputError
        No files, a bad channel map, or none of the first files can be read.
    """
    mapping = ChannelMap.load(channel_map)
    files, _ = measurement_files(source)
    counts = Counter(SUFFIXES.get(file.suffix.lower(), f"without a reader ({file.suffix})") for file in files)
    lines = ["files: " + ", ".join(f"{count} {kind}" for kind, count in sorted(counts.items()))]
    failure: InputError | None = None
    for file in files[:_TRIES]:
        try:
            table = read_file(file)
        except InputError as error:
            failure = failure or error
            lines.append(f"not readable: {error}")
            continue
        return "\n".join([*lines, *_describe(table, mapping, file.stem)])
    raise failure or InputError("no file")


def _describe(table: RawTable, mapping: ChannelMap, test_id: str) -> list[str]:
    lines = [f"first test: {table.source} ({table.format}, {len(table.frame)} rows)"]
    lines += [f"  note: {note}" for note in table.notes]
    used = {name: column for name, column in mapping.columns.items() if name in table.frame.columns}
    for name in table.frame.columns:
        column = used.get(name)
        unit = (column.unit if column is not None else None) or table.units.get(name, "")
        what = "not used" if column is None else f"-> {column.quantity} [{CHANNELS[column.quantity].unit}]"
        lines.append(f"  {name!r} [{unit or 'no unit'}] {_span(table.frame[name])} {what}")
    missing = [name for name in mapping.columns if name not in used]
    if missing:
        lines.append(f"  missing: {', '.join(repr(name) for name in missing)}; a channel map to start from:")
        return lines + draft(table).splitlines()
    try:
        row = quality_row(mapping.record(table, test_id), mapping.moving_mass or 0.0)
    except InputError as error:
        return [*lines, f"  cannot be used: {error}"]
    how = "detected" if mapping.phases is None else "stated"
    return [
        *lines,
        f"  {row['sampling_rate_Hz']:g} Hz; phases ({how}): upsetting from {row['upsetting_s']:g} s, sliding "
        f"from {row['sliding_s']:g} s at {row['speed_mm_s']:g} mm/s over {row['sliding_mm']:g} mm",
    ]


def draft(table: RawTable) -> str:
    """Return a `channels.yaml` guessed from names and units; what has no match stands as a comment."""
    import yaml

    free = list(table.frame.columns)
    channels: dict[str, dict[str, Any]] = {}
    comments = []
    for quantity, pattern in _NAMES.items():
        fitting = [name for name in free if _fits(quantity, table.units.get(name, ""))]
        name = next((n for n in fitting if re.search(pattern, n, re.IGNORECASE)), None)
        if name is None:
            comments.append(f"# no column found for {quantity} ({CHANNELS[quantity].meaning})")
            continue
        free.remove(name)
        unit = table.units.get(name, "")
        channels[name] = {"quantity": quantity, **({} if unit else {"unit": CHANNELS[quantity].unit})}
    text = yaml.safe_dump({"channels": channels}, sort_keys=False, allow_unicode=True)
    return "\n".join([text.rstrip(), *comments, "phases: detect"])


def _fits(quantity: str, unit: str) -> bool:
    if not unit:
        return True
    try:
        conversion(quantity, unit)
    except InputError:
        return False
    return True


def _span(values: pd.Series[Any]) -> str:
    numbers = pd.to_numeric(values, errors="coerce").to_numpy(np.float64)
    good = numbers[np.isfinite(numbers)]
    return f"{good.min():.5g} to {good.max():.5g}" if len(good) else "no numbers"
