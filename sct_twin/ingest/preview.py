"""A survey as text for the console: files, columns, tests, remarks; nothing is written."""

from __future__ import annotations

import os
import re
import textwrap
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common.processes.pool import Progress
from friction_models.common.wording import listed

from ..records.channels import CHANNELS
from .channel_guess import draft
from .channel_map import ChannelMap, Map
from .measurement_files import LeftOut, Source
from .quality import warnings
from .survey import FileFound, Survey, survey

_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")
_QUOTED = re.compile(r"'[^']*'")
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
    test_id: str | None = None,
) -> str:
    """Return what was found: files and their columns, every test, what to look at, what cannot be used.

    Where the map does not fit the columns, a draft of `channels.yaml` is added.

    Raises InputError: no files, or a bad channel map or test table.
    """
    return describe(survey(source, channel_map, tests, None, progress, test_id), channel_map, width)


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
        same = len({said for _, said in remark}) == 1
        said = remark[0][1] if same else f"{remark[0][1]} (numbers of the first)"
        lines += _wrapped(f"{_named([test for test, _ in remark])}: {said}", width)
    lines += [line for said in _left_out(found.left_out) for line in _wrapped(f"left out: {said}", width)]
    if found.proposal is not None:
        said = f"test_id: '{found.proposal}' (in channels.yaml, or as --test-id) takes the names of the test table out of"
        lines += _wrapped(f"{said} the file names", width)
    return lines


def _left_out(entries: Sequence[LeftOut]) -> list[str]:
    """Return why files were left out, each reason once with the first file it is about."""
    same: dict[str, list[tuple[str, str]]] = {}
    for file, reason in entries:
        # What is said of a test without a file differs in the name of the test, of files in their numbers.
        quoted = _QUOTED.search(reason)
        name = Path(file).name if file or quoted is None else quoted[0]
        key = reason.replace(file, "") if file else _QUOTED.sub("", reason)
        same.setdefault(_NUMBER.sub("#", key), []).append((name, reason))
    lines = []
    for (_, reason), *others in same.values():
        also = f" (also {_named([name for name, _ in others])})" if others else ""
        lines.append(f"{reason}{also}")
    return lines


def _named(names: Sequence[str]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f"{', '.join(names[:_NAMED])}{more}"


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


def _tests(rows: Sequence[dict[str, object]], mapping: ChannelMap, width: int) -> list[str]:
    """Return the table of tests; names are cut where a line would be longer than `width`."""
    shown = rows if len(rows) <= _SHOWN else rows[:_SHOWN]
    columns = [
        [head, unit, *(_cell(row[key], digits) for row in shown)] for head, key, digits, unit in _TABLE
    ]
    widths = [max(map(len, column)) for column in columns]
    rest = sum(widths) + 2 * len(widths)
    names = ["test", "", *(str(row["test_id"]) for row in shown)]
    names = shortened(names, max(8, width - rest))
    room = max(map(len, names))
    lines = []
    for number, text in enumerate(names):
        cells = "".join(f"  {column[number].rjust(n)}" for column, n in zip(columns, widths))
        lines.append(f"{text.ljust(room)}{cells}".rstrip())
    if len(rows) > len(shown):
        lines.append(f"and {len(rows) - len(shown)} more tests (quality.csv holds all)")
    how = Counter("stated" if row["phases"] != "detected" else "detected" for row in rows)
    phases = listed(f"{key} in {count}" for key, count in sorted(how.items()))
    about = (
        f"* F_n over the bore, without one over the specimen; upset, slide: when the phases begin ({phases}); "
        "+-: standard uncertainty of mu at one point."
    )
    return [*lines, *_wrapped(about, width)]


def shortened(names: Sequence[str], room: int) -> list[str]:
    """Return names of at most `room` characters that differ where the names differ, or the names where none such are.

    Names of one campaign differ at their ends, mostly: the middle is cut out first.
    """
    longest = max(map(len, names), default=0)
    if longest <= room:
        return list(names)
    ends = sorted(range(room), key=lambda count: abs(count - (room // 2 - 1)))
    # What is kept of a name: a beginning and an end, or a piece of the middle.
    cuts = [(slice(0, k), room - k - 1) for k in ends]
    cuts += [(slice(k, k + room - 2), 0) for k in range(1, longest - room + 2)]
    for kept, tail in cuts:
        before = "~" if kept.start else ""
        short = [n if len(n) <= room else f"{before}{n[kept]}~{n[len(n) - tail :]}" for n in names]
        if len(set(short)) == len(set(names)):
            return short
    return list(names)


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
