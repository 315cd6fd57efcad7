"""Upsetting of a cylinder: the closed form without friction, CalculiX with it."""

from __future__ import annotations

import math

from ..materials.materials import steel_16MnCr5
from ..processes.upsetting import Upsetting
from .calculix import Compression, calculix_numbers
from .case import Case, Row, account_rows, case, finished, published_flow_stress, rate_independent

GROUP = "Upsetting"
#: Numbers of an earlier CalculiX run, for machines without CalculiX.
KEPT = {"force": 236.38}
CASES: list[Case] = []


@case(CASES, "upset-frictionless", GROUP)
def frictionless() -> list[Row]:
    """Cylinder 15 x 15 mm, 50 %, 5 mm/s, isothermal, no friction."""
    process = Upsetting(mesh_size=1.25, isothermal=True, material=steel_16MnCr5())
    result = finished(process, process.run(0.0, 7.5))
    rate = 5.0 / 7.5
    expected = float(published_flow_stress(math.log(2.0), 20.0, rate)) * 2.0 * math.pi * 7.5**2 * 1e-3
    source = "closed form: kf(ln 2, 20 degC, 5 / 7.5 per s) x 2 A0"
    force = Row("force at 50 %", "kN", expected, source, result.force[-1], 0.5)
    return [force, *account_rows(result)]


@case(CASES, "upset-calculix", GROUP, fast=False)
def with_friction() -> list[Row]:
    """Cylinder 15 x 15 mm, 50 %, mu 0.1, isothermal; flow curve held at 0.5/s in both programs."""
    process = Upsetting(mesh_size=0.75, isothermal=True, material=rate_independent())
    result = finished(process, process.run(0.1, 7.5))
    setup = Compression(outer=7.5, inner=0.0, height=15.0, mu=0.1, columns=10, rows=10)
    other = calculix_numbers(setup, KEPT)
    force = other.row("force at 50 %", "kN", "force", float(result.force[-1]), 1.0)
    return [force, *account_rows(result)]
