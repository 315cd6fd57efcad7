"""Times of upsetting and sliding where the laboratory states them, in the test table or the channel map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.common.ranges import is_number
from friction_models.loads import FloatArray, missing_column

from ..readers import RawTable
from ..records.cells import check_keys, is_given
from ..records.record import SctRecord

_KEYS = ("upsetting", "sliding", "channel")
#: What the test table says about the phases of a test, in this order [s].
TIMES = ("t_upsetting", "t_sliding", "t_end")


@dataclass(frozen=True)
class PhaseTimes:
    """When the phases of a test begin and end, on the clock of its record [s]; None: to be detected.

    >>> t = np.arange(100) / 100
    >>> said = {"t_upsetting": 0.25, "t_sliding": 0.5}
    >>> PhaseTimes.of(SctRecord("sct001", t, F_n=90e3 + t, F_r=7e3 + t, s=20 * t, metadata=said))
    PhaseTimes(upsetting=0.25, sliding=0.5, end=None)
    """

    upsetting: float | None = None
    sliding: float | None = None
    end: float | None = None

    @classmethod
    def of(cls, record: SctRecord) -> PhaseTimes:
        """Read `t_upsetting`, `t_sliding`, `t_end` from a record's metadata.

        Raises InputError: not a number, outside the record, or not one after the other.
        """
        first, last = float(record.t[0]), float(record.t[-1])
        said: list[tuple[str, float]] = []
        for name in TIMES:
            if not is_given(record.metadata.get(name)):
                continue
            value = record.number(name)
            if not first <= value <= last:
                raise InputError(
                    f"{record.where}: {name} is {value:g} s, the record goes from {first:g} to {last:g} s; "
                    "allowed: a time of the record"
                )
            if said and value <= said[-1][1]:
                raise InputError(
                    f"{record.where}: {name} is {value:g} s, {said[-1][0]} is {said[-1][1]:g} s; allowed: "
                    "upsetting before sliding, sliding before its end"
                )
            said.append((name, value))
        return cls(*(dict(said).get(name) for name in TIMES))


@dataclass(frozen=True)
class Phases:
    """Upsetting and sliding as time spans [s], or as values of a channel of the file.

    >>> Phases(upsetting=(0.5, 1.0), sliding=(1.2, 2.0)).channel is None
    True
    """

    #: First and last time [s]; with `channel` the value of that channel, twice.
    upsetting: tuple[float, float]
    sliding: tuple[float, float]
    channel: str | None = None

    @classmethod
    def load(cls, content: Any, where: str) -> Phases | None:
        """Read ``detect`` (or nothing), two time spans, or a channel with two values.

        Raises InputError: unknown keys, no spans, spans that end before they begin or overlap.
        """
        if content is None or content == "detect":
            return None
        if not isinstance(content, Mapping):
            raise InputError(f"{where}: phases is {content!r}; allowed: detect, or upsetting and sliding")
        check_keys(content, _KEYS, f"{where}: phases")
        column = content.get("channel")
        if column is not None and not isinstance(column, str):
            raise InputError(f"{where}: phases: channel is {column!r}; allowed: the name of a column")
        spans = []
        for name in ("upsetting", "sliding"):
            value: Any = content.get(name)
            if column is not None:
                if not is_number(value):
                    raise InputError(f"{where}: phases: {name} is {value!r}; allowed: a value of {column!r}")
                spans.append((float(value), float(value)))
                continue
            if not (
                isinstance(value, list | tuple)
                and len(value) == 2
                and all(is_number(v) for v in value)
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

    def times(self, t: FloatArray, table: RawTable) -> dict[str, float]:
        """Return when the phases begin and end [s] in a file with these times.

        The record stays whole: the zeros of the force cells stand before and after.

        Raises InputError: the phase channel is missing, a phase does not occur or goes beyond the record, or
        sliding comes before upsetting.
        """
        if self.channel is None:
            key = t
        elif self.channel not in table.frame.columns:
            raise missing_column(self.channel, table.frame.columns, f"{table.source}: phases")
        else:
            key = table.numbers(self.channel)[0]
        found: dict[str, tuple[int, int]] = {}
        for name in ("upsetting", "sliding"):
            low, high = getattr(self, name)
            if self.channel is None and not (t[0] <= low and high <= t[-1]):
                raise InputError(
                    f"{table.source}: phases: {name} is [{low:g}, {high:g}] s, the record goes from {t[0]:g} to {t[-1]:g} s; "
                    "allowed: times of the record"
                )
            rows = np.flatnonzero((key >= low) & (key <= high))
            if not len(rows):
                what = f"column {self.channel!r} is {low:g}" if self.channel else f"{low:g} to {high:g} s"
                raise InputError(f"{table.source}: no row of the phase {name} ({what}); allowed: such rows")
            found[name] = (int(rows[0]), int(rows[-1]))
        if found["sliding"][0] < found["upsetting"][0]:
            raise InputError(f"{table.source}: sliding comes before upsetting; allowed: upsetting first")
        ends = (found["upsetting"][0], *found["sliding"])
        return {name: float(t[row]) for name, row in zip(TIMES, ends)}
