"""Which part of a file is upsetting and which is sliding, where the laboratory says so."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from friction_models.loads import InputError, missing_column, unknown_name

from .readers import RawTable

_KEYS = ("upsetting", "sliding", "channel")


@dataclass(frozen=True)
class Phases:
    """Upsetting and sliding as time spans [s], or as values of a channel of the file.

    Attributes
    ----------
    upsetting, sliding : tuple of float
        First and last time [s]; with `channel` the value of that channel, twice.
    channel : str or None
        Column that holds the phase.
    """

    upsetting: tuple[float, float]
    sliding: tuple[float, float]
    channel: str | None = None

    @classmethod
    def load(cls, content: Any, where: str) -> Phases | None:
        """Read ``detect`` (or nothing), two time spans, or a channel with two values.

        Raises
        ------
        InputError
            Unknown keys, no spans, spans that end before they begin or overlap.
        """
        if content is None or content == "detect":
            return None
        if not isinstance(content, Mapping):
            raise InputError(f"{where}: phases is {content!r}; allowed: detect, or upsetting and sliding")
        for key in content:
            if key not in _KEYS:
                raise unknown_name("key", key, _KEYS, f"{where}: phases")
        column = content.get("channel")
        if column is not None and not isinstance(column, str):
            raise InputError(f"{where}: phases: channel is {column!r}; allowed: the name of a column")
        spans = []
        for name in ("upsetting", "sliding"):
            value: Any = content.get(name)
            if column is not None:
                if not _is_number(value):
                    raise InputError(f"{where}: phases: {name} is {value!r}; allowed: a value of {column!r}")
                spans.append((float(value), float(value)))
                continue
            if not (
                isinstance(value, list | tuple)
                and len(value) == 2
                and all(_is_number(v) for v in value)
                and value[0] < value[1]
            ):
                raise InputError(f"{where}: phases: {name} is {value!r}; allowed: [first, last] time [s]")
            spans.append((float(value[0]), float(value[1])))
        upsetting, sliding = spans
        if column is None and upsetting[1] > sliding[0]:
            raise InputError(
                f"{where}: phases: upsetting ends at {upsetting[1]:g} s, sliding begins at {sliding[0]:g} s; "
                "allowed: upsetting first"
            )
        if column is not None and upsetting == sliding:
            raise InputError(f"{where}: phases: both are {sliding[0]:g}; allowed: two different values")
        return cls(upsetting, sliding, column)

    def cut(self, frame: pd.DataFrame, table: RawTable) -> tuple[pd.DataFrame, dict[str, float]]:
        """Return the record up to the end of sliding, and when the phases begin and end [s].

        What comes before upsetting stays: the zeros of the force cells are taken there.

        Raises
        ------
        InputError
            The phase channel is missing, a phase does not occur, or sliding comes before upsetting.
        """
        if self.channel is None:
            key = frame["t"].to_numpy(np.float64)
        elif self.channel not in table.frame.columns:
            raise missing_column(self.channel, table.frame.columns, f"{table.source}: phases")
        else:
            key = pd.to_numeric(table.frame[self.channel], errors="coerce").to_numpy(np.float64)
        found: dict[str, tuple[int, int]] = {}
        for name in ("upsetting", "sliding"):
            low, high = getattr(self, name)
            rows = np.flatnonzero((key >= low) & (key <= high))
            if not len(rows):
                what = f"column {self.channel!r} is {low:g}" if self.channel else f"{low:g} to {high:g} s"
                raise InputError(f"{table.source}: no row of the phase {name} ({what}); allowed: such rows")
            found[name] = (int(rows[0]), int(rows[-1]))
        if found["sliding"][0] < found["upsetting"][0]:
            raise InputError(f"{table.source}: sliding comes before upsetting; allowed: upsetting first")
        end = found["sliding"][1]
        t = frame["t"].to_numpy(np.float64)
        times = {
            "t_upsetting": float(t[found["upsetting"][0]]),
            "t_sliding": float(t[found["sliding"][0]]),
            "t_end": float(t[end]),
        }
        return frame.iloc[: end + 1].reset_index(drop=True), times


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
