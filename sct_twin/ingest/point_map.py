"""Point map: says which columns of a laboratory's table are the loads and mu, and what the names of its files hold."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from friction_models.common import InputError, unknown_name
from friction_models.common.errors import shown
from friction_models.common.ranges import is_number
from friction_models.common.units import conversion
from friction_models.loads.contract import POINT_COLUMNS, POINT_UNITS

from ..records.cells import Cell, check_keys, column_entry, map_content
from ..records.channels import check_scale

#: How a point map is given: a YAML file, or its content.
PointMapSource = str | os.PathLike[str] | Mapping[str, Any] | None
_KEYS = ("columns", "only", "file_name", "metadata")
_COLUMN_KEYS = ("quantity", "unit", "sign", "test_table")
#: A name of a column of the test table, and of a part of a file name.
_WORD = re.compile(r"[^\W\d]\w{0,59}")
_PART = re.compile(r"\{([^{}]*)\}")
#: A file name holds no more parts than this.
_MAX_PARTS = 12


@dataclass(frozen=True)
class PointColumn:
    """What a column of a file is: a quantity of a point, or a column of the test table."""

    #: One of `POINT_COLUMNS`; its unit, None where the file says it; 1 or -1, what the values are multiplied by.
    quantity: str | None = None
    unit: str | None = None
    sign: float = 1.0
    #: Name of the column in the test table.
    test_table: str | None = None


@dataclass(frozen=True)
class FileNameParts:
    """The name of a file without suffix, with ``{name}`` where something about the test stands.

    Each part ends at the first place where the text behind it begins; the last text has to be the end of the name.

    >>> FileNameParts.load("{lubricant}_{T_tool}C_{test_id}", "map").of("MoS2_200C_t07")
    {'lubricant': 'MoS2', 'T_tool': 200.0, 'test_id': 't07'}
    """

    texts: tuple[str, ...]
    names: tuple[str, ...]
    source: str

    @classmethod
    def load(cls, content: Any, where: str) -> FileNameParts | None:
        """Read a template; None where there is none.

        Raises InputError: no text, no part, a part without a name or twice, or two parts with nothing between them.
        """
        if content is None:
            return None
        refused = InputError(
            f"{where}: file_name is {content!r}; allowed: the name of a file without suffix with parts such as {{test_id}}, "
            "each once and with other text between them: '{lubricant}_{T_tool}C_{test_id}'"
        )
        if not isinstance(content, str) or not content.isprintable() or len(content) > 255:
            raise refused
        texts, names = _PART.split(content)[::2], _PART.findall(content)
        if (
            not 0 < len(names) <= _MAX_PARTS
            or len({*names}) < len(names)
            or any(_WORD.fullmatch(name) is None for name in names)
            or "" in texts[1:-1]
            or any("{" in text or "}" in text for text in texts)
        ):
            raise refused
        return cls(tuple(texts), tuple(names), content)

    def of(self, name: str, where: str = "") -> dict[str, Cell]:
        """Return what a name says; numbers as such, but the name of the test is text.

        Raises InputError: the name does not fit.
        """
        refused = InputError(f"{where}the name {name!r} does not fit file_name {self.source!r}")
        if not name.startswith(self.texts[0]):
            raise refused
        found: dict[str, Cell] = {}
        rest = name[len(self.texts[0]) :]
        for part, text in zip(self.names, self.texts[1:], strict=True):
            last = part == self.names[-1]
            place = (len(rest) - len(text) if rest.endswith(text) else -1) if last else rest.find(text, 1)
            if place < 1:
                raise refused
            found[part] = rest[:place] if part == "test_id" else _number_or_text(rest[:place])
            rest = rest[place + len(text) :]
        return found


@dataclass(frozen=True)
class PointMap:
    """Columns by name, limits of the rows that are kept, parts of file names, and metadata that all tests share.

    `columns` None stands for the names of the contract.

    >>> found = PointMap.load({"columns": {"speed": {"quantity": "v_rel", "unit": "m/s"}, "COF": "mu"}})
    >>> found.columns["speed"].unit, found.columns["COF"].quantity
    ('m/s', 'mu')
    >>> PointMap.load({"columns": {"COF": "friction"}})
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: ...unknown quantity 'friction'; allowed: ...
    """

    columns: Mapping[str, PointColumn] | None = None
    #: Smallest and largest value of a column [its unit in the file]; rows outside are left out.
    only: Mapping[str, tuple[float | None, float | None]] = field(default_factory=dict)
    file_name: FileNameParts | None = None
    metadata: Mapping[str, Cell] = field(default_factory=dict)
    source: str = "point map"

    @classmethod
    def load(cls, source: PointMapSource) -> PointMap:
        """Read a point map from YAML or a dictionary; None stands for the names of the contract.

        Raises InputError: unreadable YAML, unknown keys or quantities, a quantity that stands twice, no mu, a unit that
        does not fit.
        """
        if source is None:
            return cls()
        content, where = map_content(source, "point map", _KEYS)
        return cls(
            _columns(content.get("columns"), where),
            _only(content.get("only"), where),
            FileNameParts.load(content.get("file_name"), where),
            _metadata(content.get("metadata"), where),
            where,
        )

    def used(self, present: list[str]) -> dict[str, PointColumn]:
        """Return the columns of a file that are used."""
        if self.columns is None:
            return {name: PointColumn(name) for name in present if name in POINT_COLUMNS}
        return {name: column for name, column in self.columns.items() if name in present}


def _number_or_text(text: str) -> Cell:
    """Return a number where a part of a name is one, also with a decimal comma."""
    number = re.fullmatch(r"[+-]?\d{1,15}([.,]\d{1,15})?", text)
    return float(text.replace(",", ".")) if number else text.strip()


def _columns(content: Any, where: str) -> dict[str, PointColumn] | None:
    if content is None:
        return None
    if not isinstance(content, Mapping) or not content:
        raise InputError(f"{where}: columns is {content!r}; allowed: names of columns and what they are")
    columns = {str(name): _column(entry, f"{where}: column {str(name)!r}") for name, entry in content.items()}
    for kind, names in (
        ("quantity", [c.quantity for c in columns.values() if c.quantity]),
        ("column of the test table", [c.test_table for c in columns.values() if c.test_table]),
    ):
        twice = [name for name in names if names.count(name) > 1]
        if twice:
            raise InputError(
                f"{where}: {kind} {twice[0]!r} is mapped {names.count(twice[0])} times; allowed: once"
            )
    if all(column.quantity != "mu" for column in columns.values()):
        raise InputError(f"{where}: no column is mu; allowed: one column with the measured friction")
    return columns


def _column(entry: Any, here: str) -> PointColumn:
    entry = column_entry(entry, _COLUMN_KEYS, here)
    quantity, unit, sign, test_table = (entry.get(key) for key in _COLUMN_KEYS)
    if (quantity is None) == (test_table is None):
        raise InputError(f"{here}: {dict(entry)!r}; allowed: either quantity or test_table")
    if test_table is not None:
        if set(entry) != {"test_table"}:
            raise InputError(f"{here}: {dict(entry)!r}; allowed: test_table alone")
        return PointColumn(test_table=_word(test_table, here))
    if quantity not in POINT_COLUMNS:
        raise unknown_name("quantity", str(quantity), POINT_COLUMNS, here)
    if sign is not None and sign not in (1, -1):
        raise InputError(f"{here}: sign is {sign!r}; allowed: 1 or -1")
    if unit is not None:
        if quantity == "test_id":
            raise InputError(f"{here}: a unit of test_id; allowed: none")
        conversion(POINT_UNITS[quantity], check_scale(unit, here), quantity, here)
    return PointColumn(quantity, unit, float(sign or 1.0))


def _only(content: Any, where: str) -> dict[str, tuple[float | None, float | None]]:
    form = "names of columns with min, max or both"
    if content is None:
        return {}
    if not isinstance(content, Mapping):
        raise InputError(f"{where}: only is {content!r}; allowed: {form}")
    limits = {}
    for name, entry in content.items():
        here = f"{where}: only: {str(name)!r}"
        if not isinstance(entry, Mapping) or not entry:
            raise InputError(f"{here}: {entry!r}; allowed: {form}")
        check_keys(entry, ("min", "max"), here)
        low, high = entry.get("min"), entry.get("max")
        for value in (low, high):
            if value is not None and not is_number(value):
                raise InputError(f"{here}: {value!r}; allowed: finite numbers")
        if low is not None and high is not None and low > high:
            raise InputError(f"{here}: min {low} above max {high}; allowed: min up to max")
        limits[str(name)] = (low, high)
    return limits


def _metadata(content: Any, where: str) -> dict[str, Cell]:
    if content is None:
        return {}
    if not isinstance(content, Mapping) or any(
        not isinstance(value, str | int | float) for value in content.values()
    ):
        raise InputError(f"{where}: metadata is {content!r}; allowed: names with values")
    for name, value in content.items():
        if isinstance(value, str) and not value.isprintable():
            raise InputError(
                f"{where}: metadata {name!r} is {shown(value, 60)!r}; allowed: a text of one line without control characters"
            )
    return {_word(name, where): value for name, value in content.items()}


def _word(name: Any, where: str) -> str:
    if not isinstance(name, str) or _WORD.fullmatch(name) is None or name == "test_id":
        raise InputError(
            f"{where}: {name!r} for a column of the test table; allowed: letters, digits and underscores, not test_id"
        )
    return name
