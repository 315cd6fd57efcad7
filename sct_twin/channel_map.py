"""How the columns of a laboratory's files become the channels of a record."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from friction_models.loads import InputError, missing_column, unknown_name

from .channels import CHANNEL_NAMES, channel, check_scale
from .phases import Phases
from .readers import RawTable
from .record import SctRecord
from .units import conversion

#: A channel map is a page of text.
_MAX_BYTES = 1_000_000
_KEYS = ("channels", "moving_mass", "metadata", "phases")


@dataclass(frozen=True)
class MappedColumn:
    """One column of a file: `channel = sign * (reading - offset)`, offset and reading in `unit`."""

    quantity: str
    unit: str | None = None
    sign: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class ChannelMap:
    """Columns by name, the mass that moves with the plate [kg] and metadata that all files share."""

    columns: Mapping[str, MappedColumn] = field(
        default_factory=lambda: {name: MappedColumn(name) for name in CHANNEL_NAMES}
    )
    moving_mass: float | None = None
    metadata: Mapping[str, Any] = field(default_factory=dict)
    phases: Phases | None = None
    source: str = "channel map"

    @classmethod
    def load(cls, source: str | os.PathLike[str] | Mapping[str, Any] | None) -> ChannelMap:
        """Read a channel map from YAML or a dictionary; None stands for canonical names.

        The layout is ``channels: {column name: {quantity, unit, sign, offset}}``, ``moving_mass: kg``,
        ``metadata: {...}``, ``phases: detect`` or what `Phases.load` takes.

        Raises
        ------
        InputError
            Unreadable YAML, unknown keys or quantities, a quantity mapped twice or not at all.
        """
        if source is None:
            return cls()
        where = "channel map"
        content: Any = source
        if not isinstance(source, Mapping):
            import yaml

            where = str(source)
            path = Path(source)
            if not path.is_file():
                raise InputError(f"{path}: no such file; allowed: a YAML file with a channel map")
            if path.stat().st_size > _MAX_BYTES:
                raise InputError(f"{path}: {path.stat().st_size} bytes; allowed: at most {_MAX_BYTES}")
            try:
                content = yaml.safe_load(path.read_text(encoding="utf-8"))
            except (yaml.YAMLError, ValueError, RecursionError) as error:
                said = (str(error).splitlines() or [type(error).__name__])[0]
                raise InputError(f"{path}: not YAML ({said})") from None
        if not isinstance(content, Mapping):
            raise InputError(f"{where}: holds {type(content).__name__}, allowed: keys {', '.join(_KEYS)}")
        for key in content:
            if key not in _KEYS:
                raise unknown_name("key", key, _KEYS, where)
        columns = _columns(content.get("channels"), where)
        mass = content.get("moving_mass")
        if mass is not None and not (_is_number(mass) and 0.0 <= mass < 1e5):
            raise InputError(f"{where}: moving_mass is {mass!r}; allowed: 0 to 1e5 kg")
        metadata = content.get("metadata") or {}
        if not isinstance(metadata, Mapping):
            raise InputError(f"{where}: metadata is {metadata!r}; allowed: names with values")
        phases = Phases.load(content.get("phases"), where)
        return cls(columns, None if mass is None else float(mass), dict(metadata), phases, where)

    def record(self, table: RawTable, test_id: str, metadata: Mapping[str, Any] | None = None) -> SctRecord:
        """Return the record that a file holds, in canonical channels and units.

        Raises
        ------
        InputError
            A mapped column is missing, has no unit or one that does not fit, or its values are bad.
        """
        data: dict[str, Any] = {}
        for name, column in self.columns.items():
            if name not in table.frame.columns:
                raise missing_column(name, table.frame.columns, table.source)
            unit = column.unit or table.units.get(name, "")
            if not unit:
                raise InputError(
                    f"{table.source}: column {name!r} has no unit; allowed: one of "
                    f"{', '.join(channel(column.quantity).units)} in a units row or in the channel map"
                )
            factor, shift = conversion(column.quantity, unit, table.source)
            values = table.frame[name]
            if values.dtype.kind not in "fiu":
                numbers = pd.to_numeric(values, errors="coerce")
                bad = (numbers.isna() & values.notna()).to_numpy()
                if bad.any():
                    row = int(np.argmax(bad))
                    raise InputError(
                        f"{table.source}: column {name!r}, row {row}: value {values.iloc[row]!r} "
                        f"is not a number [{unit}]"
                    )
                values = numbers
            data[column.quantity] = column.sign * (
                (values.to_numpy(np.float64) - column.offset) * factor + shift
            )
        frame = pd.DataFrame(data)
        about = {**self.metadata, **(metadata or {})}
        if self.phases is not None:
            frame, times = self.phases.cut(frame, table)
            about |= times
        return SctRecord.from_frame(test_id, frame, about, table.source)


def _columns(content: Any, where: str) -> dict[str, MappedColumn]:
    if content is None:
        return {name: MappedColumn(name) for name in CHANNEL_NAMES}
    if not isinstance(content, Mapping) or not content:
        raise InputError(f"{where}: channels is {content!r}; allowed: column names with quantity and unit")
    columns: dict[str, MappedColumn] = {}
    for name, entry in content.items():
        here = f"{where}: channel {str(name)!r}"
        if isinstance(entry, str):
            entry = {"quantity": entry}
        if not isinstance(entry, Mapping):
            raise InputError(f"{here}: {entry!r}; allowed: quantity, unit, sign, offset")
        for key in entry:
            if key not in {"quantity", "unit", "sign", "offset"}:
                raise unknown_name("key", key, ["quantity", "unit", "sign", "offset"], here)
        quantity = channel(str(entry.get("quantity")), here).name
        unit = entry.get("unit")
        if unit is not None:
            conversion(quantity, check_scale(unit, here), here)
        sign, offset = entry.get("sign", 1), entry.get("offset", 0.0)
        if sign not in (1, -1):
            raise InputError(f"{here}: sign is {sign!r}; allowed: 1 or -1")
        if not _is_number(offset):
            raise InputError(f"{here}: offset is {offset!r}; allowed: a finite number in the file's unit")
        columns[str(name)] = MappedColumn(quantity, unit, float(sign), float(offset))
    quantities = [column.quantity for column in columns.values()]
    for name in CHANNEL_NAMES:
        if quantities.count(name) != 1:
            raise InputError(
                f"{where}: quantity {name!r} is mapped {quantities.count(name)} times; allowed: exactly once"
            )
    return columns


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))
