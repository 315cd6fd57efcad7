"""Surface expansion and pressure that the twin reads from an upsetting run, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from forming import PowerLaw, PunchGeometry
from sct_twin.twin.upsetting import ContactState, UpsettingCase, known_upset, run_force

FORCE = 250e3


@pytest.fixture(scope="module")
def state() -> ContactState:
    """The contact under 250 kN without friction, 700 MPa (0.005 + phi)^0.15."""
    steel = PowerLaw(K=700.0, n=0.15, prestrain=0.005)
    case = UpsettingCase(PunchGeometry(), run_force(FORCE), 0.7, steel, 0.0, 20.0, 20.0)
    return ContactState.from_result(known_upset(case, "test"), FORCE, case)


def test_expansion_without_friction_is_that_of_the_area(state: ContactState) -> None:
    """F = 700 (0.005 + phi)^0.15 A0 e^phi and A / A0 = e^phi; it was 4 % less with the edge counted twice."""
    start = np.pi * 7.5**2
    phi = brentq(lambda p: 700.0 * (0.005 + p) ** 0.15 * start * np.exp(p) - FORCE, 1e-6, 3.0)
    assert state.psi == pytest.approx(np.exp(phi), rel=0.003)
    assert state.area == pytest.approx(start * np.exp(phi), rel=0.003)


def test_the_pressure_carries_the_force(state: ContactState) -> None:
    r = state.radius * state.radius_fraction
    fine = np.linspace(0.0, state.radius, 2001)
    carried = np.trapezoid(2.0 * np.pi * fine * np.interp(fine, r, state.pressure), fine)
    assert carried == pytest.approx(FORCE, rel=0.003)
    # Even pressure: the flow stress, but for the last node, which carries less than its ring.
    assert state.pressure[:-3] == pytest.approx(FORCE / state.area, rel=0.01)
