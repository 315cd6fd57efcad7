"""What measurement files hold and what a channel map makes of it, as text; nothing is written."""

from __future__ import annotations

import os
import re
import textwrap
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from friction_models.loads import InputError

from .channel_map import ChannelMap
from .channels import CHANNELS
from .quality import warnings
from .readers import RawTable
from .survey import FileFound, Map, Progress, Source, Survey, survey
from .units import conversion

#: Names that laboratories give to their channels, tried in this order.
_NAMES: dict[str, str] = {
    "t": r"^(t|time|timestamps?|zeit)\b|\b(time|zeit)\b",
    "F_n": r"\b(f_?n|f_?z|normal|kraft[ _]?[zn]|load|axial)",
    "F_r": r"\b(f_?r|f_?t|f_?x|fric|reib|tang|kraft[ _]?x|shear)",
    "a": r"\b(a|acc\w*|beschl\w*)\b",
    "T_plate": r"\b(t_?plate|temp\w*|thermo\w*)",
    "s": r"\b(s|pos\w*|weg\w*|disp\w*|path|stroke|slide)\b",
    "v": r"\b(v|vel\w*|speed\w*|geschw\w*)\b",
}
_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")
#: Of more tests than this only the first are shown; quality.csv has all.
_SHOWN = 40
#: Tests that are named behind a remark.
_NAMED = 6
#: Heading, key of the quality row and digits behind the point of the table that is shown.
_TABLE = (
    ("rate", "sampling_rate_Hz", None, "Hz"),
    ("length", "duration_s", 2, "s"),
    ("upset", "upsetting_s", 3, "s"),
    ("slide", "sliding_s", 3, "s"),
    ("v", "speed_mm_s", 1, "mm/s"),
    ("sd", "sliding_mm", 1, "mm"),
    ("T", "T_plate_degC", 0, "degC"),
    ("sigma*", "sigma_guess_MPa", 0, "MPa"),
    ("mu", "mu_mean", 4, ""),
    ("+-", "mu_std", 5, ""),
)


def preview(
    source: Source,
    channel_map: Map = None,
    tests: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    width: int = 80,
) -> str:
    """Return what was found: files and their columns, every test, what to look at, what cannot be used.

    Where the map does not fit the columns, a draft of `channels.yaml` is added.

    Raises
    ------
    InputError
        No files, or a bad channel map or test table.
    """
    return describe(survey(source, channel_map, tests, progress=progress), channel_map, width)


def describe(found: Survey, channel_map: Map = None, width: int = 80) -> str:
    """Return a survey as text; lines are at most `width` long where words allow."""
    mapping = ChannelMap.load(channel_map)
    lines: list[str] = []
    groups: dict[Any, list[FileFound]] = {}
    for file in found.files:
        groups.setdefault(file.layout, []).append(file)
    for group in groups.values():
        lines += [*_layout(group, width), ""]
    if found.rows:
        lines += [*_tests(found.rows, mapping, width), ""]
    lines += remarks(found, width)
    first = found.files[0].table if found.files else None
    if not found.rows and first is not None and mapping.missing(first):
        lines += ["a map to start from (as channels.yaml, for --map):", "", *draft(first).splitlines()]
    return "\n".join(lines).rstrip()


def remarks(found: Survey, width: int = 80) -> list[str]:
    """Return what to look at, each remark once with the tests it is about, and what was left out."""
    about: dict[str, list[tuple[str, str]]] = {}
    for row in found.rows:
        named = {str(k): None if isinstance(v, float) and np.isnan(v) else v for k, v in row.items()}
        for said in warnings(named):
            # The same remark with other numbers is one remark.
            about.setdefault(_NUMBER.sub("#", said), []).append((str(row["test_id"]), said))
    lines = []
    for remark in about.values():
        tests = [test for test, _ in remark]
        more = f" and {len(tests) - _NAMED} more" if len(tests) > _NAMED else ""
        same = len({said for _, said in remark}) == 1
        said = remark[0][1] if same else f"{remark[0][1]} (numbers of the first)"
        lines += _wrapped(f"{', '.join(tests[:_NAMED])}{more}: {said}", width)
    for entry in found.left_out:
        lines += _wrapped(f"left out: {entry['reason']}", width)
    return lines


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
            if quantity != "v" or "s" not in [entry["quantity"] for entry in channels.values()]:
                comments.append(f"# no column found for {quantity} ({CHANNELS[quantity].meaning})")
            continue
        free.remove(name)
        unit = table.units.get(name, "")
        channels[name] = {"quantity": quantity, **({} if unit else {"unit": CHANNELS[quantity].unit})}
    text = yaml.safe_dump({"channels": channels}, sort_keys=False, allow_unicode=True)
    return "\n".join([text.rstrip(), *comments, "phases: detect"])


def _layout(group: Sequence[FileFound], width: int) -> list[str]:
    """Describe files of one layout: how many, and the columns with their ranges over all of them."""
    first = group[0]
    what = Path(first.file).name if len(group) == 1 else f"{len(group)} files, first {Path(first.file).name}"
    lines = [f"{what} ({first.format})"]
    cells = []
    for number, column in enumerate(first.columns):
        low = min(file.columns[number].low for file in group)
        high = max(file.columns[number].high for file in group)
        span = "no numbers" if np.isnan(low) else f"{low:.5g} to {high:.5g}"
        channel = None if column.quantity is None else CHANNELS[column.quantity]
        to = "not used" if channel is None else f"-> {channel.name} [{channel.unit}]"
        cells.append((repr(column.name), f"[{column.unit or 'no unit'}]", span, to))
    widths = [max(len(row[k]) for row in cells) for k in range(3)]
    for row in cells:
        lines.append("  " + "  ".join(cell.ljust(n) for cell, n in zip(row, widths)) + f"  {row[3]}")
    notes = Counter(note for file in group for note in file.notes)
    for note, count in notes.items():
        lines += _wrapped(f"note: {note}" + (f" ({count} files)" if count > 1 else ""), width, "  ")
    return lines


def _tests(rows: Sequence[dict[str, Any]], mapping: ChannelMap, width: int) -> list[str]:
    """Return the table of tests; names are cut where a line would be longer than `width`."""
    shown = rows if len(rows) <= _SHOWN else rows[:_SHOWN]
    columns = [
        [head, unit, *(_cell(row[key], digits) for row in shown)] for head, key, digits, unit in _TABLE
    ]
    widths = [max(map(len, column)) for column in columns]
    rest = sum(widths) + 2 * len(widths)
    names = ["test", "", *(str(row["test_id"]) for row in shown)]
    room = min(max(map(len, names)), max(8, width - rest))
    lines = []
    for number, name in enumerate(names):
        # Names of one campaign differ at their ends.
        text = name if len(name) <= room else name[: room // 2 - 1] + "~" + name[room // 2 - room :]
        cells = "".join(f"  {column[number].rjust(n)}" for column, n in zip(columns, widths))
        lines.append(f"{text.ljust(room)}{cells}".rstrip())
    if len(rows) > len(shown):
        lines.append(f"and {len(rows) - len(shown)} more tests (quality.csv holds all)")
    how = Counter("stated" if row["phases"] != "detected" else "detected" for row in rows)
    phases = " and ".join(f"{key} in {count}" for key, count in sorted(how.items()))
    about = (
        f"* F_n over the bore, without one over the specimen; upset, slide: when the phases begin ({phases}); "
        "+-: standard uncertainty of mu at one point."
    )
    return [*lines, *_wrapped(about, width)]


def _cell(value: Any, digits: int | None) -> str:
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return "-"
    return f"{value:.4g}" if digits is None else f"{value:.{digits}f}"


def _wrapped(text: str, width: int, indent: str = "") -> list[str]:
    return textwrap.wrap(
        text,
        max(width, 40),
        initial_indent=indent,
        subsequent_indent=indent + "    ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def _fits(quantity: str, unit: str) -> bool:
    if not unit:
        return True
    try:
        conversion(quantity, unit)
    except InputError:
        return False
    return True
