"""Channel map: turns the columns of a laboratory's files into the channels of a record."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from friction_models.common import InputError
from friction_models.common.ranges import is_number
from friction_models.loads import FloatArray, missing_column

from ..readers import RawTable
from ..readers.header import numbered
from ..records.cells import Cell, column_entry, is_given, map_content
from ..records.channels import CHANNEL_NAMES, MOTION, REQUIRED, channel, check_scale
from ..records.record import SctRecord
from ..records.units import channel_conversion, scale_factor
from ..signals.phases import TIMES, Phases
from .measurement_files import NameTemplate
from .phase_files import PhaseFiles, join

#: How a channel map is given: a YAML file, or its content.
Map = str | os.PathLike[str] | Mapping[str, Any] | None
_KEYS = ("channels", "moving_mass", "metadata", "phases", "despike", "low_pass", "test_id")
_COLUMN_KEYS = ("quantity", "unit", "sign", "offset", "scale", "sensitivity", "std")


@dataclass(frozen=True)
class MappedColumn:
    """One column of a file: `channel = sign * (reading - offset)`, offset and reading in `unit`.

    `scale` (``5 kN/V``) or `sensitivity` (``200 mV/kN``) turn readings of a sensor into the quantity; `std`
    is the standard uncertainty of a force cell [N].

    >>> MappedColumn("F_n", unit="kN").factor("kN", "map")
    (1000.0, 0.0)
    """

    quantity: str
    unit: str | None = None
    sign: float = 1.0
    offset: float = 0.0
    scale: str | None = None
    sensitivity: str | None = None
    std: float | None = None

    def factor(self, unit: str, where: str) -> tuple[float, float]:
        """Return (factor, shift) from readings in `unit` to the canonical unit."""
        scale = self.scale or self.sensitivity
        if scale is None:
            return channel_conversion(self.quantity, unit, where)
        return scale_factor(self.quantity, unit, scale, self.scale is None, where), 0.0


@dataclass(frozen=True)
class ChannelMap:
    """Columns by name, the mass that moves with the plate [kg] and metadata that all files share.

    `columns` None stands for canonical names, of which a file may lack those that can be done without.
    `phases` says when the phases are, `files` how the files of one test are called where there are two, `names` which
    part of a file's name is that of the test.

    Without a map the columns of a file have the names and units of a record:

    >>> ChannelMap.load(None) == ChannelMap()
    True
    >>> ChannelMap.load({"channels": {"force": {"quantity": "F_m"}}})
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: ...unknown quantity 'F_m'; allowed: ...
    """

    columns: Mapping[str, MappedColumn] | None = None
    moving_mass: float | None = None
    metadata: Mapping[str, Cell] = field(default_factory=dict)
    phases: Phases | None = None
    files: PhaseFiles | None = None
    names: NameTemplate | None = None
    source: str = "channel map"

    @classmethod
    def load(cls, source: Map) -> ChannelMap:
        """Read a channel map from YAML or a dictionary; None stands for canonical names.

        The layout is ``channels: {column name: {quantity, unit, sign, offset}}``, ``moving_mass: kg``,
        ``metadata: {...}``, ``phases: detect`` or what `Phases.load` takes, ``test_id`` as `NameTemplate.load` takes it.

        Raises InputError: unreadable YAML, unknown keys or quantities, a quantity mapped twice or not at all.

        >>> columns = {
        ...     "time [s]": {"quantity": "t"},
        ...     "force": {"quantity": "F_n", "unit": "kN"},
        ...     "drive": {"quantity": "F_r", "unit": "kN", "sign": -1},
        ...     "way": {"quantity": "s", "unit": "mm"},
        ... }
        >>> found = ChannelMap.load({"channels": columns, "moving_mass": 25})
        >>> found.moving_mass, found.columns["drive"].sign
        (25.0, -1.0)
        """
        if source is None:
            return cls()
        content, where = map_content(source, "channel map", _KEYS)
        columns = _columns(content.get("channels"), where)
        mass = content.get("moving_mass")
        if mass is not None and not (is_number(mass) and 0.0 <= mass < 1e5):
            raise InputError(f"{where}: moving_mass is {mass!r}; allowed: 0 to 1e5 kg")
        metadata = content.get("metadata") or {}
        if not isinstance(metadata, Mapping):
            raise InputError(f"{where}: metadata is {metadata!r}; allowed: names with values")
        shared = dict(metadata)
        for name in ("despike", "low_pass"):
            if content.get(name) is not None:
                shared[name] = _processing(name, content[name], where)
        for column in (columns or {}).values():
            if column.std is not None:
                shared[f"{column.quantity}_std"] = column.std
        phases = content.get("phases")
        files = PhaseFiles.load(phases, where)
        return cls(
            columns,
            None if mass is None else float(mass),
            shared,
            None if files is not None else Phases.load(phases, where),
            files,
            NameTemplate.load(content.get("test_id"), where),
            where,
        )

    def used(self, table: RawTable) -> dict[str, MappedColumn]:
        """Return the columns of a table that become channels."""
        if self.columns is not None:
            return {name: column for name, column in self.columns.items() if name in table.frame.columns}
        return {name: MappedColumn(name) for name in CHANNEL_NAMES if name in table.frame.columns}

    def missing(self, table: RawTable, upsetting: bool = False) -> list[str]:
        """Return the columns that a table should have and does not; less is needed of an upsetting file."""
        used = self.used(table)
        if upsetting:
            have = {column.quantity for column in used.values()}
            return [name for name in ("t", "F_n") if name not in have]
        if self.columns is not None:
            return [name for name in self.columns if name not in used]
        lacking = [name for name in REQUIRED if name not in used]
        return lacking if any(name in used for name in MOTION) else [*lacking, MOTION[0]]

    def channels(self, table: RawTable, upsetting: bool = False) -> dict[str, FloatArray]:
        """Return the channels that a table holds, in canonical units.

        Raises InputError: a column is missing, has no unit or one that does not fit, or holds text.
        """
        for name in self.missing(table, upsetting):
            if twice := numbered(name, table.frame.columns):
                raise InputError(
                    f"{table.source}: column {name!r} stands {len(twice)} times; allowed: a channel map that says which "
                    f"is meant, {' or '.join(map(repr, twice))}"
                )
            error = missing_column(name, table.frame.columns, table.source)
            if self.columns is None:
                raise InputError(
                    f"{error}; a channel map (--map) says which column it is, --dry-run drafts one"
                )
            raise error
        data: dict[str, FloatArray] = {}
        for name, column in self.used(table).items():
            unit = column.unit or table.units.get(name, "")
            if not unit:
                raise InputError(
                    f"{table.source}: column {name!r} has no unit; allowed: one of "
                    f"{', '.join(channel(column.quantity).units)} in a units row or in the channel map"
                )
            factor, shift = column.factor(unit, table.source)
            readings, bad = table.numbers(name)
            if bad is not None:
                raise InputError(
                    f"{table.source}: column {name!r}, {table.place(bad)}: value {table.frame[name].iloc[bad]!r} "
                    f"is not a number; allowed: numbers [{unit}] (mend the line, or take it out)"
                )
            if (column.sign, column.offset, factor, shift) != (1.0, 0.0, 1.0, 0.0):
                readings = column.sign * ((readings - column.offset) * factor + shift)
            data[column.quantity] = readings
        return data

    def record(self, table: RawTable, test_id: str, metadata: Mapping[str, Cell] | None = None) -> SctRecord:
        """Return the record that a file holds, in canonical channels and units.

        Raises InputError: a mapped column is missing, has no unit or one that does not fit, its values are
        bad, or the map and the metadata disagree about the phases.
        """
        channels = self.channels(table)
        about = {**self.metadata, **(metadata or {})}
        if self.phases is not None:
            _add_times(about, self.phases.times(channels["t"], table), table.source)
        return SctRecord.of_channels(test_id, channels, about, table.source, table.first_line)

    def joined(
        self, upsetting: RawTable, sliding: RawTable, test_id: str, metadata: Mapping[str, Cell] | None = None
    ) -> tuple[SctRecord, list[str]]:
        """Return the record that an upsetting file and a sliding file make, and what was assumed.

        Raises InputError: as `record`; or the two do not fit together.
        """
        about = {**self.metadata, **(metadata or {})}
        parts = self.channels(upsetting, upsetting=True), self.channels(sliding)
        channels, notes = join(*parts, upsetting.source, sliding.source, about.get("t_wait"))
        return SctRecord.of_channels(test_id, channels, about, sliding.source), notes


def _add_times(about: dict[str, Cell], times: Mapping[str, float], where: str) -> None:
    for name in TIMES:
        known = about.get(name)
        if is_given(known) and str(known) != str(times[name]):
            raise InputError(
                f"{where}: {name} is {known} in the test table and {times[name]:g} s by the phases of the "
                "channel map; allowed: one of both"
            )
    about |= times


def _processing(name: str, value: Any, where: str) -> Any:
    if name == "despike" and not isinstance(value, bool):
        raise InputError(f"{where}: despike is {value!r}; allowed: true or false")
    if name == "low_pass" and value != "auto" and not (is_number(value) and 0.0 < value < 1e6):
        raise InputError(f"{where}: low_pass is {value!r}; allowed: a corner above 0 Hz, or auto")
    return value


def _columns(content: Any, where: str) -> dict[str, MappedColumn] | None:
    if content is None:
        return None
    if not isinstance(content, Mapping) or not content:
        raise InputError(f"{where}: channels is {content!r}; allowed: column names with quantity and unit")
    columns = {
        str(name): _column(entry, f"{where}: channel {str(name)!r}") for name, entry in content.items()
    }
    quantities = [column.quantity for column in columns.values()]
    for name in CHANNEL_NAMES:
        count = quantities.count(name)
        if count > 1 or (count == 0 and name in REQUIRED):
            allowed = "exactly once" if name in REQUIRED else "once at most"
            raise InputError(f"{where}: quantity {name!r} is mapped {count} times; allowed: {allowed}")
    if not any(name in quantities for name in MOTION):
        raise InputError(f"{where}: neither 's' nor 'v' is mapped; allowed: position, speed or both")
    return columns


def _column(entry: Any, here: str) -> MappedColumn:
    entry = column_entry(entry, _COLUMN_KEYS, here)
    quantity = channel(str(entry.get("quantity")), here).name
    unit, std = entry.get("unit"), entry.get("std")
    sign, offset = entry.get("sign", 1), entry.get("offset", 0.0)
    if sign not in (1, -1):
        raise InputError(f"{here}: sign is {sign!r}; allowed: 1 or -1")
    if not is_number(offset):
        raise InputError(f"{here}: offset is {offset!r}; allowed: a finite number in the file's unit")
    if std is not None and not (quantity in ("F_n", "F_r") and is_number(std) and std >= 0.0):
        raise InputError(f"{here}: std is {std!r}; allowed: of F_n and F_r, 0 N and more")
    scale, sensitivity = entry.get("scale"), entry.get("sensitivity")
    if scale is not None and sensitivity is not None:
        raise InputError(f"{here}: both scale and sensitivity; allowed: one of them")
    for said in (scale, sensitivity):
        if said is not None and not isinstance(said, str):
            raise InputError(f"{here}: {said!r} has no unit; allowed: a number with a unit, such as '5 kN/V'")
    column = MappedColumn(
        quantity,
        None if unit is None else check_scale(unit, here),
        float(sign),
        float(offset),
        scale,
        sensitivity,
        None if std is None else float(std),
    )
    if column.unit is not None:
        column.factor(column.unit, here)
    return column
