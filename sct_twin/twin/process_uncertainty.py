"""Standard uncertainties of the loads of a test that was driven step by step: the columns of an evaluated test."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from friction_models.common import InputError
from friction_models.loads import FloatArray

from .heat.thermal_settings import ThermalSettings
from .process import LOADED, SctProcess
from .uncertainty import (
    COARSE,
    GivenUncertainty,
    load_uncertainties,
    other_dimensions,
    other_friction,
)
from .upsetting import ContactAtPoints, ContactState, UpsettingRun, fills, known_upset


def process_uncertainties(
    process: SctProcess,
    dt: FloatArray,
    F_n: FloatArray,
    v_slide: FloatArray,
    T_tool: FloatArray,
    mu: FloatArray,
    given: GivenUncertainty | None = None,
) -> dict[str, FloatArray]:
    """Return what the loads may be off by when a process is driven from its start; its own state stays.

    They are the columns of an evaluated test: `u_sigma_n` [MPa], `u_psi` and `u_T` [K], standard uncertainties, nearly
    all of it common to the steps. The inputs of n steps, as `SctProcess.advance` takes them, hold; what they may be off by
    is not in them. Each column has the shape (n + 1,): at the start and at the end of every step.

    Raises InputError: no step, or an input that is not finite or out of its physical range.

    A filled bore: of its diameter 0.02 mm are uncertain, and 0.8 % of the pressure by the mesh.

    >>> steps = {"F_n": 330e3, "v_slide": 100.0, "T_tool": 20.0, "mu": 0.08}
    >>> inputs = {name: np.full(10, value) for name, value in steps.items()}
    >>> found = process_uncertainties(SctProcess(mesh_size=0.9), np.full(10, 0.005), **inputs)
    >>> [len(u) for u in found.values()], float(found["u_sigma_n"][-1].round())
    ([11, 11, 11], 15.0)
    """
    given = given or GivenUncertainty()
    steps = np.column_stack([dt, F_n, v_slide, T_tool, mu])
    if not len(steps):
        raise InputError("SCT process: 0 steps; allowed: at least one")
    steps = np.vstack([[0.0, *steps[0, 1:]], steps])
    force = steps[:, 1]
    moving = np.flatnonzero(steps[:, 0] * steps[:, 2] > 0.0)
    upset_to = float(force[: moving[0] if len(moving) else None].max())
    if upset_to < LOADED:
        upset_to = process.F_max
    usual, case = process.upsetting, process.upsetting.case

    def driven(
        thermal: ThermalSettings, area_factor: float = 1.0, warmer: float = 0.0
    ) -> dict[str, FloatArray]:
        other = process.restarted(thermal, replace(usual, area_factor=area_factor, warmer=warmer))
        loads = np.array([other.advance(*step) for step in steps.tolist()])
        return dict(zip(process.load_names, loads.T))

    def read(run: UpsettingRun) -> ContactAtPoints:
        return run.at_points(force, upset_to)

    def at_friction(upsetting_mu: float) -> ContactAtPoints:
        other = replace(case, mu=upsetting_mu)
        return read(UpsettingRun(known_upset(other, "SCT process"), other))

    loads = driven(replace(process.thermal, cells=min(COARSE, process.thermal.cells)))
    others = [
        read(replace(usual, flow_stress=1.0 + given.flow_stress)),
        *other_dimensions(usual, force, upset_to, given.diameter),
        *other_friction(at_friction, case.mu, given),
    ]
    state = usual.at(upset_to)

    def temperature(other: ContactState, thermal: ThermalSettings) -> FloatArray:
        return driven(thermal, other.area / state.area, other.T_specimen - state.T_specimen)["T"]

    return load_uncertainties(
        loads["sigma_n"],
        loads["T"] - steps[:, 3],
        read(usual),
        others,
        state,
        case.T0,
        process.thermal,
        temperature,
        given,
        fills(2.0 * state.radius, case.punch),
    )
