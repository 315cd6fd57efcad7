"""Forward rod and backward cup extrusion: steady force, Dipper's band, energy, volume, mesh halving."""

from __future__ import annotations

import math

import numpy as np

from ..processes.backward_cup_extrusion import BackwardCupExtrusion
from ..processes.forward_rod_extrusion import ForwardRodExtrusion
from ..processes.friction_input import Friction
from ..processes.stepwise import StepwiseProcess
from .case import Case, Row, account_rows, case, finished, published_flow_stress

GROUP = "Extrusion"
#: Strokes between which the force of the rod is steady: the front has left the land, the punch is above the cone [mm].
STEADY = (8.0, 19.5)
#: Allowed deviations [%]: steady force, mesh halving, Dipper's formula.
FLAT, HALVING, DIPPER = 0.5, 1.0, 20.0
CASES: list[Case] = []


class _Isothermal(StepwiseProcess):
    def start(self, mu: Friction = 0.08) -> None:
        super().start(mu)
        self.simulation.heat = None


class IsothermalRod(_Isothermal, ForwardRodExtrusion):
    """Forward rod extrusion without any heat."""


class IsothermalCup(_Isothermal, BackwardCupExtrusion):
    """Backward cup extrusion without any heat."""


@case(CASES, "fre-frictionless", GROUP, fast=False)
def rod_without_friction() -> list[Row]:
    """Forward rod extrusion 20 to 14.14 mm, 90 degrees, 20 mm stroke, isothermal, no friction."""
    process = IsothermalRod(tool_heating=False)
    result = finished(process, process.run(0.0, 20.0))
    steady = (result.stroke >= STEADY[0]) & (result.stroke <= STEADY[1])
    force = result.smooth_force[steady]
    mean = float(force.mean())
    farthest = float(force[np.abs(force - mean).argmax()])
    what = f"steady force, farthest from its mean at {STEADY[0]:g} to {STEADY[1]:g} mm"
    return [Row(what, "kN", mean, "steady flow: constant force", farthest, FLAT), *account_rows(result)]


@case(CASES, "fre-mesh", GROUP, fast=False)
def rod_mesh() -> list[Row]:
    """Forward rod extrusion 20 to 14.14 mm, 90 degrees, mu 0.08, 6 mm stroke, with tool heat."""
    return _halving(*(ForwardRodExtrusion(mesh_size=h) for h in (0.4, 0.2)))


def dipper(D: float, d: float, h0: float, h1: float, mu: float) -> float:
    """Return the punch force of backward cup extrusion after Dipper [kN], flow stresses at 20 degC and 10/s.

    F = A [kf1 (1 + mu d / (3 h1)) + kf2 (1 + (h1 / s) (1/4 + mu / 2))], phi1 = ln(h0 / h1),
    phi2 = phi1 (1 + d / (8 s)), s = (D - d) / 2; Lange, Umformtechnik 2.
    """
    s = 0.5 * (D - d)
    phi1 = math.log(h0 / h1)
    kf1, kf2 = published_flow_stress([phi1, phi1 * (1.0 + d / (8.0 * s))], 20.0, 10.0)
    pressure = kf1 * (1.0 + mu * d / (3.0 * h1)) + kf2 * (1.0 + h1 / s * (0.25 + 0.5 * mu))
    return float(0.25 * math.pi * d**2 * pressure) * 1e-3


@case(CASES, "bce-frictionless", GROUP, fast=False)
def cup_without_friction() -> list[Row]:
    """Backward cup extrusion, billet 20 x 20 mm, punch 14.14 mm, 14 mm stroke, isothermal, no friction."""
    process = IsothermalCup(tool_heating=False)
    result = finished(process, process.run(0.0, 14.0))
    plateau = float(np.interp(10.0, result.stroke, result.smooth_force))
    expected = dipper(20.0, 14.14, 20.0, 10.0, 0.0)
    row = Row("force at 10 mm", "kN", expected, "Dipper's formula, a band", plateau, DIPPER)
    return [row, *account_rows(result)]


@case(CASES, "bce-mesh", GROUP, fast=False)
def cup_mesh() -> list[Row]:
    """Backward cup extrusion, billet 20 x 20 mm, punch 14.14 mm, mu 0.08, 6 mm stroke, with tool heat."""
    return _halving(*(BackwardCupExtrusion(mesh_size=h) for h in (0.35, 0.175)))


def _halving(
    usual: ForwardRodExtrusion | BackwardCupExtrusion, half: ForwardRodExtrusion | BackwardCupExtrusion
) -> list[Row]:
    coarse, fine = (finished(process, process.run(0.08, 6.0)) for process in (usual, half))
    what, source = (f"elements of {process.mesh_size:g} mm" for process in (usual, half))
    row = Row(f"Fmax with {what}", "kN", fine.max_force, source, coarse.max_force, HALVING)
    return [row, *account_rows(coarse)]
