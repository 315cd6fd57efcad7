"""Upsetting of a cylinder: the closed form without friction, CalculiX with it."""

from __future__ import annotations

import math

from ..materials.materials import steel_16MnCr5
from ..processes.upsetting import Upsetting
from .calculix import Compression
from .calculix_rows import KeptNumbers, calculix_numbers, calculix_row
from .case import Case, Row, account_rows, finished, published_flow_stress, rate_independent

GROUP = "Upsetting"
#: Numbers of an earlier CalculiX run, for machines without CalculiX.
KEPT = KeptNumbers("2.20", "2026-11-21", {"force": 236.38})


def frictionless() -> list[Row]:
    """Cylinder 15 x 15 mm, 50 %, no friction: kf(ln 2) times the doubled area."""
    process = Upsetting(mesh_size=1.25, isothermal=True, material=steel_16MnCr5())
    result = finished(process, process.run(0.0, 7.5))
    rate = 5.0 / 7.5
    expected = float(published_flow_stress(math.log(2.0), 20.0, rate)) * 2.0 * math.pi * 7.5**2 * 1e-3
    source = "closed form: kf(ln 2, 20 degC, 5 / 7.5 per s) x 2 A0"
    force = Row("force at 50 %", "kN", expected, source, result.force[-1], 0.5)
    return [force, *account_rows(result)]


def with_friction() -> list[Row]:
    """Cylinder 15 x 15 mm, 50 %, mu 0.1, isothermal, one flow curve in both programs."""
    process = Upsetting(mesh_size=0.75, isothermal=True, material=rate_independent())
    result = finished(process, process.run(0.1, 7.5))
    other = calculix_numbers(
        Compression(outer=7.5, inner=0.0, height=15.0, mu=0.1, columns=10, rows=10), KEPT
    )
    return [
        calculix_row("force at 50 %", "kN", other, "force", float(result.force[-1]), 1.0),
        *account_rows(result),
    ]


CASES = (
    Case(
        "upset-frictionless",
        GROUP,
        "Cylinder 15 x 15 mm, 50 %, 5 mm/s, isothermal, no friction.",
        frictionless,
    ),
    Case(
        "upset-calculix",
        GROUP,
        "Cylinder 15 x 15 mm, 50 %, mu 0.1, isothermal; flow curve held at 0.5/s in both programs.",
        with_friction,
        fast=False,
    ),
)
