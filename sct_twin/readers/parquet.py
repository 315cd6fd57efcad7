"""Parquet tables; a column's unit stands in its metadata (``unit``) or in its name."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from friction_models.common import InputError

from .table import RawTable, Signal, check_shape, split_unit, table_of_signals, text_of


def read_parquet(file: Path) -> RawTable:
    """Read the columns that hold numbers; what other libraries left in the metadata is not looked at.

    Raises InputError: damaged, too large, or no column of numbers.
    """
    parquet = pq.ParquetFile(file, thrift_string_size_limit=10**7, thrift_container_size_limit=10**6)
    head = parquet.metadata
    check_shape(head.num_rows, head.num_columns, str(file))
    notes: list[str] = []
    wanted: list[str] = []
    units: dict[str, str] = {}
    for field in parquet.schema_arrow:
        number = pa.types.is_floating(field.type) or pa.types.is_integer(field.type)
        if not number and not pa.types.is_string(field.type):
            notes.append(f"column {text_of(field.name)!r} holds {text_of(field.type)}: left out")
            continue
        about = {text_of(k).lower(): text_of(v) for k, v in (field.metadata or {}).items()}
        units[field.name] = about.get("unit") or about.get("units") or split_unit(field.name)[1]
        wanted.append(field.name)
    if len(set(wanted)) != len(wanted):
        twice = next(name for name in wanted if wanted.count(name) > 1)
        raise InputError(f"{file}: column {text_of(twice)!r} stands twice in the table; allowed: once")
    table = parquet.read(columns=wanted, use_pandas_metadata=False, use_threads=False)
    signals = []
    for name in wanted:
        column = table.column(name)
        if pa.types.is_string(column.type):
            # A column of texts that are not all numbers is a label, not a channel.
            try:
                column = column.cast(pa.float64())
            except pa.ArrowInvalid:
                notes.append(f"column {text_of(name)!r} holds text: left out")
                continue
        values = column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
        signals.append(Signal(split_unit(text_of(name))[0], units[name], values))
    return table_of_signals(signals, str(file), "Parquet", notes)
