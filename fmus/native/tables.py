"""Constants as C text: numbers without rounding, shared tables, names, the tables of the FMI variables."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from friction_models.loads import LOADS

from ..interface.friction_source import FrictionSource
from ..interface.quantities import FrictionInterface, parameter_arrays
from .tensors import Array


def literal(value: float) -> str:
    """Return a C constant that is exactly `value` (hexadecimal).

    Examples
    --------
    >>> literal(0.5), literal(-3.0)
    ('0x1.0000000000000p-1', '(-0x1.8000000000000p+1)')
    """
    if not math.isfinite(value):
        return "NAN" if math.isnan(value) else "INFINITY" if value > 0 else "(-INFINITY)"
    text = float(value).hex()
    return f"({text})" if text.startswith("-") else text


def table(name: str, values: Sequence[float] | Array) -> str:
    """Return the definition of a constant array of doubles."""
    return rows(name, [literal(v) for v in np.ravel(values).astype(float).tolist()], "double")


def rows(name: str, texts: Sequence[str], kind: str) -> str:
    """Return the definition of a constant array of elements written already, eight a line."""
    lines = [", ".join(texts[i : i + 8]) for i in range(0, len(texts), 8)]
    # Vectors that cross a line of the cache cost twice.
    aligned = "TF_ALIGNED " if len(texts) >= 8 else ""
    start = f"TF_UNUSED {aligned}static const {kind} {name}[{len(texts)}]"
    return f"{start} = {{\n    " + ",\n    ".join(lines) + "};\n"


class Tables:
    """Constant tables of a model; equal ones are written once, whichever function uses them."""

    def __init__(self) -> None:
        self._names: dict[bytes, str] = {}
        self._definitions: list[str] = []

    def add(self, values: Array) -> str:
        """Return the name of a table of doubles."""
        numbers = np.ascontiguousarray(values, dtype=np.float64)
        return self._add(numbers.tobytes(), lambda name: table(name, numbers))

    def add_rows(self, texts: Sequence[str], kind: str) -> str:
        """Return the name of a table whose elements are written already."""
        return self._add(f"{kind} {texts}".encode(), lambda name: rows(name, texts, kind))

    def _add(self, key: bytes, write: Callable[[str], str]) -> str:
        if key not in self._names:
            self._names[key] = name = f"c{len(self._names)}"
            self._definitions.append(write(name))
        return self._names[key]

    def text(self) -> str:
        """Return all definitions."""
        return "\n".join(self._definitions)


def interface_tables(source: FrictionSource, interface: FrictionInterface) -> str:
    """Return names, limits and start values of the loads, states and system variables."""
    lower = [interface.domain.get(q.name, (-np.inf, np.inf))[0] for q in LOADS]
    upper = [interface.domain.get(q.name, (-np.inf, np.inf))[1] for q in LOADS]
    # As friction_models.models.domain.Domain: the width of the range; for a load that never varied its size, at least 1.
    scale = [b - a if b > a else max(abs(b), 1.0) for a, b in zip(lower, upper)]
    # C has no empty arrays: without states or system variables one unused element stands there.
    parts = [
        _names("tf_load_names", [q.name for q in LOADS]),
        _names("tf_state_names", [s.name for s in source.states]),
        _names("tf_system_names", [p.name for p in source.system]),
        table("tf_load_lower", [q.lower for q in LOADS]),
        table("tf_load_upper", [q.upper for q in LOADS]),
        table("tf_load_start", [interface.start(q) for q in LOADS]),
        table("tf_domain_lower", lower),
        table("tf_domain_upper", upper),
        table("tf_domain_scale", scale),
        table("tf_state_start", [s.start for s in source.states] or [0.0]),
        table("tf_system_start", [p.start for p in source.system] or [0.0]),
        table("tf_system_lower", [-np.inf if p.lower is None else p.lower for p in source.system] or [0.0]),
        table("tf_system_upper", [np.inf if p.upper is None else p.upper for p in source.system] or [0.0]),
        *_array_tables(source),
    ]
    return "\n".join(parts)


def _array_tables(source: FrictionSource) -> list[str]:
    """Return, for each system variable, the length of the array that begins with it (0 inside of one), and whether it must rise."""
    lengths, rises = [1] * len(source.system), [0] * len(source.system)
    for array in parameter_arrays(source.system):
        lengths[array.first : array.first + array.size] = [array.size] + [0] * (array.size - 1)
        rises[array.first] = int(array.rises)
    return [
        rows("tf_system_length", [str(k) for k in lengths] or ["0"], "int"),
        rows("tf_system_rises", [str(k) for k in rises] or ["0"], "int"),
    ]


def _names(name: str, texts: Sequence[str]) -> str:
    quoted = ", ".join(f'"{"".join(c for c in t if c.isalnum() or c in "_.,[]")}"' for t in texts) or '""'
    return f"TF_UNUSED static const char *const {name}[] = {{{quoted}}};"
