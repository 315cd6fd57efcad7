"""``--target c``: one header and one source file around the text that the FMU is compiled from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from friction_models.loads import LOADS

from ...interface.friction_source import FrictionSource
from ...native.generate import generate
from ..common import Files, Reference, description, one_line, template, test_box

#: Agreement of a compiled export with ONNX Runtime, relative and absolute.
RELATIVE, ABSOLUTE = 1e-12, 1e-14
#: Points of the self-test inside the domain and beyond it, and steps of its history.
_INSIDE, _OUTSIDE, _STEPS = 24, 8, 12
_BUILD = """\
  cc -std=c99 -O2 -ffp-contract=off -c {P}.c       (any C99 compiler; never with -ffast-math)
  cc -std=c99 -O2 -ffp-contract=off selftest.c {P}.c -lm -o selftest && ./selftest
"""


def c_number(value: float) -> str:
    """Return a C constant that is exactly `value`.

    Examples
    --------
    >>> c_number(0.5), c_number(-1.0)
    ('0x1.0000000000000p-1', '-0x1.0000000000000p+0')
    """
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return float(value).hex()


def c_values(source: FrictionSource, prefix: str) -> dict[str, str]:
    """Return what the C templates need, but for the model itself."""
    states, system = len(source.states), len(source.system)
    infinite = (-math.inf, math.inf)
    loads = [
        _row(q.name, q.unit, q.meaning, (q.lower, q.upper), source.domain.get(q.name, infinite), start)
        for q, start in zip(LOADS, (source.interface(1).start(q) for q in LOADS))
    ]
    memory = [
        _row(s.name, s.unit, "memory of the contact point", infinite, infinite, s.start)
        for s in source.states
    ]
    variables = [
        _row(
            p.name,
            p.unit,
            "system variable",
            (-math.inf if p.lower is None else p.lower, math.inf if p.upper is None else p.upper),
            infinite,
            p.start,
        )
        for p in source.system
    ]
    empty = [_row("", "", "", infinite, infinite, 0.0)]
    step = _STEP if states else _NO_STEP
    values = description(source) | {
        "P": prefix,
        "UP": prefix.upper(),
        "STATES": str(states),
        "SYSTEM": str(system),
        "STATES_OR_1": str(max(states, 1)),
        "SYSTEM_OR_1": str(max(system, 1)),
        "MOST": str(max(states, system, 1)),
        "LOAD_TABLE": "".join(loads),
        "STATE_TABLE": "".join(memory or empty),
        "SYSTEM_TABLE": "".join(variables or empty),
    }
    values["STEP"] = step.replace("@UP@", values["UP"]).replace("@N@", values["STATES_OR_1"])
    return values


def _row(
    name: str, unit: str, meaning: str, limits: tuple[float, float], domain: tuple[float, float], start: float
) -> str:
    texts = ", ".join('"' + one_line(t).replace('"', "'") + '"' for t in (name, unit, meaning))
    numbers = ", ".join(c_number(x) for x in (*limits, *domain, start))
    return f"    {{{texts},\n     {numbers}}},\n"


_NO_STEP = """\
    (void)state; /* the model has no memory */
    return finite_values(loads, @UP@_LOADS) && (!system || finite_values(system, @UP@_SYSTEM)) && isfinite(dt) &&
                   dt >= 0.0
               ? @UP@_OK
               : @UP@_NOT_FINITE;
"""
_STEP = """\
    double limited[@UP@_LOADS], next[@N@];
    if (!system) system = tf_system_start;
    if (!good_input(loads, state, system) || !isfinite(dt) || dt < 0.0) return @UP@_NOT_FINITE;
    tf_limited(loads, 0, limited);
    if (!(limited[2] > 0.0) || dt == 0.0) return @UP@_OK; /* no contact, or no time: nothing happens */
    tf_model_step(limited, state, system, dt, next);
    if (!finite_values(next, @UP@_STATES)) return @UP@_NO_RESULT;
    memcpy(state, next, sizeof next);
    return @UP@_OK;
"""


def c_sources(source: FrictionSource, values: Mapping[str, str]) -> dict[str, str]:
    """Return the header and the source file; `values` are those of `c_values`.

    Raises InputError: the graph holds something that is not translated.
    """
    rules = (Path(__file__).parents[2] / "native" / "domain.h").read_text(encoding="utf-8")
    texts = {**values, "MODEL": generate(source, source.interface(1)), "RULES": rules}
    return {f"{values['P']}.{end}": template(f"friction.{end}", texts) for end in ("h", "c")}


def _array(name: str, values: npt.ArrayLike, size: str) -> str:
    numbers = [c_number(float(x)) for x in np.ravel(values)]
    rows = ",\n    ".join(", ".join(numbers[i : i + 5]) for i in range(0, len(numbers), 5))
    return f"static const double {name}[{size}] = {{\n    {rows}}};\n"


def selftest(source: FrictionSource, values: Mapping[str, str]) -> str:
    """Return the C program that compares the export with ONNX Runtime.

    It holds points inside the domain, then beyond it, and a history over the first of them: time steps, and mu after each.
    """
    reference = Reference(source)
    lower, upper = test_box(source)
    rng = np.random.default_rng(20)
    points = rng.uniform(lower, upper, size=(_INSIDE + _OUTSIDE, len(LOADS)))
    points[0], points[1] = lower, upper
    points[_INSIDE:] += rng.choice([-0.2, 0.2], size=(_OUTSIDE, len(LOADS))) * (upper - lower)
    points[_INSIDE:] = np.clip(points[_INSIDE:], *reference.limits)
    # A law may have no value far outside its data; the FMU refuses there and a self-test has nothing to compare.
    lost = ~np.isfinite(reference.model.predict(points))
    points[lost] = np.clip(points[lost], *reference.domain)
    dt = rng.uniform(1e-3, 2e-2, size=_STEPS)
    stepped = np.empty(_STEPS)
    state = reference.model.start_state(1)
    for k in range(_STEPS):
        state = reference.step(points[k : k + 1], state, float(dt[k]))
        stepped[k] = reference.mu(points[k : k + 1], state)[0]
    rows = ",\n    ".join("{" + ", ".join(c_number(float(x)) for x in row) + "}" for row in points)
    nan_point = ["NAN", *(c_number(source.interface(1).start(q)) for q in LOADS[1:])]
    texts = [
        f"static const double points[POINTS][{len(LOADS)}] = {{\n    {rows}}};\n",
        _array("clamped_mu", reference.mu(points), "POINTS"),
        _array("free_mu", reference.mu(points, clamp=False), "POINTS"),
        _array("distance", reference.distance(points), "POINTS"),
        _array("time_step", dt, "STEPS"),
        _array("stepped_mu", stepped, "STEPS"),
        f"static const double not_a_number[{len(LOADS)}] = {{{', '.join(nan_point)}}};\n",
    ]
    return template(
        "selftest.c",
        {
            **values,
            "POINTS": str(len(points)),
            "STEPS": str(_STEPS),
            "DATA": "".join(texts),
            "RELATIVE": repr(RELATIVE),
            "ABSOLUTE": repr(ABSOLUTE),
        },
    )


def c_files(source: FrictionSource, prefix: str, values: dict[str, str]) -> Files:
    """Return what a C export has beside the C text and the documents."""
    values["BUILD"] = _BUILD.format(P=prefix)
    return {"selftest.c": selftest(source, values)}
