"""Common parts of the cases: flow curves, the check that a run has ended, balance of energy and volume."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..fe.mesh.shape import FloatArray
from ..materials.materials import HenselSpittel, steel_16MnCr5
from ..processes.base import FormingProcess
from ..results.result import FormingResult
from .case import Row, Unfinished

#: Published coefficients of 16MnCr5, kept apart from the product's: A [MPa], m1 [1/K], m2, m3, m4.
PUBLISHED = (677.443, -0.000788968, 0.103451, 0.0253737, 8.45076e-05)
#: Rate at which rate-independent comparisons hold the flow curve [1/s].
FROZEN_RATE = 0.5
#: Allowed error of the energy balance and of the unloaded volume [%].
ENERGY, VOLUME = 0.5, 0.1


def published_flow_stress(strain: npt.ArrayLike, T: float, rate: float) -> FloatArray:
    """Return the flow stress of 16MnCr5 after Hensel and Spittel from the published coefficients [MPa].

    The strain is bounded from below as the product does it: sqrt(strain^2 + 0.002^2).
    """
    A, m1, m2, m3, m4 = PUBLISHED
    phi = np.hypot(np.asarray(strain, dtype=np.float64), 2e-3)
    return A * np.exp(m1 * T + m4 / phi) * phi**m2 * rate**m3


def rate_independent() -> HenselSpittel:
    """Return 16MnCr5 with its flow curve held at 0.5/s, as CalculiX is given it."""
    steel = steel_16MnCr5()
    return replace(steel, A=steel.A * FROZEN_RATE**steel.m3, m3=0.0)


def finished(process: FormingProcess, result: FormingResult) -> FormingResult:
    """Return the result of a run that has reached its end.

    Raises Unfinished: the run stopped before its end.
    """
    if result.status != "ok":
        raise Unfinished(f"{process.name}: {result.message}")
    return result


def account_rows(result: FormingResult) -> list[Row]:
    """Return the rows on the energy balance and the unloaded volume of a run."""
    balance = "work of the punch = plastic + friction + elastic + contact springs"
    energy, volume = 100.0 * result.energy_balance, 100.0 * result.volume_change
    return [
        Row("energy balance", "%", 0.0, balance, energy, ENERGY, absolute=True),
        Row("unloaded volume", "%", 0.0, "plastic flow keeps it", volume, VOLUME, absolute=True),
    ]
