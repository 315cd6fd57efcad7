"""Ports: sets of variables of one FMU that are read or written together."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from friction_models.loads import FloatArray

from .fmu_variables import Variable

if TYPE_CHECKING:
    from ctypes import _SimpleCData

#: How values of a type lie in memory, by the name that FMI's get and set functions give the type.
C_TYPES: dict[str, type[_SimpleCData[Any]]] = {
    "fmi2Real": ctypes.c_double,
    "fmi2Integer": ctypes.c_int,
    "fmi2Boolean": ctypes.c_int,
    "fmi3Float64": ctypes.c_double,
    "fmi3Float32": ctypes.c_float,
    "fmi3Int8": ctypes.c_int8,
    "fmi3UInt8": ctypes.c_uint8,
    "fmi3Int16": ctypes.c_int16,
    "fmi3UInt16": ctypes.c_uint16,
    "fmi3Int32": ctypes.c_int32,
    "fmi3UInt32": ctypes.c_uint32,
    "fmi3Int64": ctypes.c_int64,
    "fmi3UInt64": ctypes.c_uint64,
    "fmi3Boolean": ctypes.c_bool,
}


@dataclass(frozen=True)
class Group:
    """Variables of one type: what one call of FMI moves.

    Value `rows[k]` of the port stands at `places[k]` of the `buffer` that the FMU reads and writes; None: the buffer is the
    port's own. `arguments` are those of the call, after the instance: references, their number, values and (FMI 3.0) their
    number.
    """

    exchange: str
    rows: npt.NDArray[np.intp] | None
    places: npt.NDArray[np.intp] | None
    buffer: npt.NDArray[Any]
    arguments: tuple[Any, ...]


class Port:
    """A set of numeric variables of one FMU, read or written in one call a type.

    `values` holds them as float64 in their order, at first with their start values; where an array is given, contiguous
    float64 of shape (variables,), they are there, and what is in it is kept. Of an FMI 3.0 array the elements that are not
    in the port keep what was read last.

    Examples
    --------
    >>> from fmus.runtime.fmu_variables import Variable
    >>> port = Port([Variable("T", 1, "Real", "input", "degC", starts=(20.0,)), Variable("psi", 2, "Real", "input", "1")])
    >>> port.values, port.index
    (array([20.,  0.]), {'T': 0, 'psi': 1})
    """

    def __init__(self, variables: Iterable[Variable], values: FloatArray | None = None) -> None:
        self.variables = list(variables)
        starts = np.array([v.starts[v.element] for v in self.variables], dtype=np.float64)
        self.values: FloatArray = starts if values is None else values
        self.index = {v.name: i for i, v in enumerate(self.variables)}
        kinds = dict.fromkeys(v.exchange for v in self.variables)
        self.groups = [self._group(kind) for kind in kinds]

    def _group(self, exchange: str) -> Group:
        rows = [i for i, v in enumerate(self.variables) if v.exchange == exchange]
        offsets: dict[int, int] = {}
        starts: list[float] = []
        for i in rows:
            variable = self.variables[i]
            if variable.reference not in offsets:
                offsets[variable.reference] = len(starts)
                starts += variable.starts
        places = [offsets[self.variables[i].reference] + self.variables[i].element for i in rows]
        kind = C_TYPES[exchange]
        own = kind is ctypes.c_double and places == list(range(len(starts))) and rows == places
        whole = own and len(rows) == len(self.variables)
        # No copy where the values are the buffer: the FMU reads and writes the array itself.
        buffer = self.values if whole else np.array(starts).astype(kind)
        references = (ctypes.c_uint * len(offsets))(*offsets)
        arguments: tuple[Any, ...] = (
            references,
            ctypes.c_size_t(len(offsets)),
            buffer.ctypes.data_as(ctypes.POINTER(kind)),
        )
        if exchange.startswith("fmi3"):
            arguments += (ctypes.c_size_t(len(buffer)),)
        if whole:
            return Group(exchange, None, None, buffer, arguments)
        return Group(
            exchange, np.array(rows, dtype=np.intp), np.array(places, dtype=np.intp), buffer, arguments
        )

    def to_buffers(self) -> None:
        """Copy the values to where the FMU reads them."""
        for group in self.groups:
            if group.rows is not None:
                group.buffer[group.places] = self.values[group.rows]

    def from_buffers(self) -> None:
        """Copy what the FMU wrote to the values."""
        for group in self.groups:
            if group.rows is not None:
                self.values[group.rows] = group.buffer[group.places]

    def vectors(self) -> dict[str, npt.NDArray[np.intp]]:
        """Return where the elements of each structured name stand among the values."""
        rows: dict[str, list[int]] = {}
        for k, variable in enumerate(self.variables):
            rows.setdefault(variable.name.partition("[")[0], []).append(k)
        return {name: np.array(places, dtype=np.intp) for name, places in rows.items()}

    @property
    def is_partial(self) -> bool:
        """Whether arrays are exchanged of which not all elements are in the port."""
        return any(g.places is not None and len(g.places) < len(g.buffer) for g in self.groups)

    @property
    def is_direct(self) -> bool:
        """Whether the FMU reads and writes `values` itself."""
        return all(group.rows is None for group in self.groups)
