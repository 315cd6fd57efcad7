"""Guesses which columns of a point table are what, drafts a point map, and shows what would be read."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from friction_models.common import InputError
from friction_models.common.processes.pool import Progress
from friction_models.common.units import conversion
from friction_models.common.wording import counted
from friction_models.loads.contract import POINT_COLUMNS, POINT_UNITS

from ..readers import RawTable, read_file
from .channel_guess import UMLAUTS, name_and_unit
from .measurement_files import Source
from .point_map import PointMap, PointMapSource
from .point_tables import point_files, read_point_tables

#: Words of a heading by which a column is recognised, in the order in which they are tried.
_WORDS: tuple[tuple[str, str], ...] = (
    ("mu", r"^(mu|cof|friction ?coefficient|coefficient of friction|reibwert|reib(ungs)?zahl|reib(ungs)?koeff\w*|µ|μ)$"),
    ("test_id", r"^(test|test ?id|test ?no|test ?nr|versuch\w*|run|run ?id|probe|specimen|sample|name)$"),
    ("v_rel", r"^(v|v ?rel|speed|velocity|sliding ?(speed|velocity)|(gleit)?geschw(indigkeit)?)$"),
    ("sigma_n", r"^(sigma|sigma ?n|p|pressure|contact ?pressure|normal ?(stress|pressure)|(kontakt)?normalspannung|druck|flaechenpressung)$"),
    ("sd", r"^(sd|s|distance|sliding ?distance|gleitweg|weg|reibweg)$"),
    ("psi", r"^(psi|surface ?(expansion|enlargement)|d?a d?a ?0|oberflaechenvergroesserung)$"),
    ("t", r"^(t|time|zeit|t ?since.*|elapsed ?time|messzeit)$"),
    ("T", r"^(temp|temperature|temperatur|t ?contact|contact ?temperature|kontakttemperatur)$"),
)  # fmt: skip


def guess_point_columns(table: RawTable) -> dict[str, dict[str, str]]:
    """Return a draft of the columns of a point map: what is recognised by its name, and what belongs to the test table.

    To the test table belong texts, and numbers that stay the same all through every test.

    >>> import pandas as pd
    >>> frame = pd.DataFrame({"test": ["a"], "v_mm_s": [1.0], "COF": [0.1], "T_K": [300.0], "oil": ["x"]})
    >>> guess_point_columns(RawTable(frame, {}, "file.csv"))["T_K"]
    {'quantity': 'T', 'unit': 'K'}
    """
    columns: dict[str, dict[str, str]] = {}
    headings = [str(heading) for heading in table.frame.columns]
    for heading in headings:
        bare, unit = name_and_unit(heading)
        words = re.sub(r"[\W_]+", " ", bare.translate(UMLAUTS)).strip().casefold()
        number = table.frame[heading].dtype.kind in "fiu"
        exact = bare if bare in POINT_COLUMNS else ""
        found = exact or next((q for q, form in _WORDS if re.search(form, words)), "")
        if found and found != "test_id" and not number:
            found = ""
        if found and any(entry.get("quantity") == found for entry in columns.values()):
            continue
        if found:
            stated = table.units.get(heading, "")
            known = unit if unit and not stated and _measures(found, unit) else ""
            columns[heading] = {"quantity": found, **({"unit": known} if known else {})}
        elif not number and _word_of(heading):
            columns[heading] = {"test_table": _word_of(heading)}
    taken = {entry.get("test_table", "") for entry in columns.values()}
    left = [h for h in headings if h not in columns and _word_of(h) not in taken | {""}]
    columns |= {h: {"test_table": _word_of(h)} for h in _same_in_each_test(table, columns, left)}
    return {heading: columns[heading] for heading in headings if heading in columns}


def _same_in_each_test(table: RawTable, columns: dict[str, dict[str, str]], left: list[str]) -> list[str]:
    """Return which columns have one value a test; none where tests have no names, or one row each: then all columns would."""
    test = next((heading for heading, entry in columns.items() if entry.get("quantity") == "test_id"), None)
    if test is None or table.frame[test].value_counts().min() < 2:
        return []
    values = table.frame.groupby(test)[left].nunique(dropna=False)
    return [heading for heading in left if (values[heading] == 1).all()]


def _measures(quantity: str, unit: str) -> bool:
    try:
        return quantity != "test_id" and conversion(POINT_UNITS[quantity], unit, quantity) is not None
    except InputError:
        return False


def _word_of(heading: str) -> str:
    """Return a heading as a name of the test table."""
    word = re.sub(r"\W+", "_", heading).strip("_")[:60]
    return "" if not word or word[0].isdigit() or word == "test_id" else word


def draft_point_map(table: RawTable) -> str:
    """Return a point map to start from, as YAML."""
    import yaml

    text: str = yaml.safe_dump({"columns": guess_point_columns(table)}, allow_unicode=True, sort_keys=False)
    return text


def describe_points(
    source: Source,
    point_map: PointMapSource = None,
    progress: Progress | None = None,
    show: Callable[[str], None] = print,
) -> None:
    """Show what is in the first file, and what would be read; where the map does not fit, a map to start from.

    Raises InputError: what `read_point_tables` refuses of files that fit the map.
    """
    files = point_files(source)
    table = read_file(files[0])
    used = PointMap.load(point_map).used([str(c) for c in table.frame.columns])
    many = f"{len(files)} files, first " if len(files) > 1 else ""
    show(f"{many}{files[0].name} ({table.format})")
    for name in map(str, table.frame.columns):
        column = used.get(name)
        to = "not used" if column is None else f"-> {column.quantity or f'test table: {column.test_table}'}"
        unit = (column.unit if column else None) or table.units.get(name, "") or "no unit"
        show(f"  {name!r}  [{unit}]  {_range(table, name)}  {to}")
    try:
        found = read_point_tables(source, point_map, progress)
    except InputError as error:
        if point_map is not None:
            raise
        show(f"{error}\na map to start from (as points.yaml, for --map):\n\n{draft_point_map(table)}")
        return
    for note in found.notes:
        show(note)
    show(found.headline())


def _range(table: RawTable, name: str) -> str:
    numbers, _ = table.numbers(name)
    if np.isnan(numbers).all():
        return counted(table.frame[name].nunique(), "text")
    return f"{np.nanmin(numbers):.5g} to {np.nanmax(numbers):.5g}"
