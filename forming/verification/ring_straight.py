"""The ring under the assumptions of the closed form: the bore stays straight and nothing hardens.

One row of elements over the height lets the radial velocity depend on the radius alone, as in Avitzur's field; the flow
stress is constant and so low that elastic compression does not show. What is left to compare is what the two
have in common: friction law, contact, plastic flow, and how the bore follows from them.
"""

from __future__ import annotations

import numpy as np

from ..fe.body import Body
from ..fe.increment import Settings
from ..fe.mesh.mesher import grid_mesh
from ..fe.simulation import Simulation
from ..fe.state import StepControl
from ..fe.tooling import flat_punch, plate
from ..materials.materials import PowerLaw, steel_16MnCr5
from ..processes.friction_input import CONSTANT_SHEAR
from ..processes.upsetting import bore_profile
from .case import Outcome, Row, Unfinished
from .ring_tables import CURVES, POINTS, REDUCTIONS, SOURCE, within, worst

OUTER, INNER, HEIGHT = 6.0, 3.0, 4.0
#: Flow stress [MPa]: with 600 MPa elastic compression moves the narrowest bore by 6 points, with this by 0.2.
YIELD_STRESS = 20.0
#: Elements over the wall, and the largest increment over the height. Where the bore all but closes (m 1, 60 %) the elements
#: beside it become the widest; at high mu narrow columns tilt.
FINENESS = {"mu": (30, 0.0125), "m": (60, 0.005)}
SPEED = 5.0


def perfectly_plastic(yield_stress: float) -> PowerLaw:
    """Return 16MnCr5 with a constant flow stress [MPa]."""
    steel = steel_16MnCr5()
    return PowerLaw(
        name="perfectly plastic",
        yield_stress=yield_stress,
        E=steel.E,
        nu=steel.nu,
        rho=steel.rho,
        cp=steel.cp,
        conductivity=steel.conductivity,
    )


def straight_ring(law: str, value: float) -> Simulation:
    """Return the ring with one row of elements; `law` is ``"mu"`` or ``"m"``, `value` its coefficient."""
    columns, increment = FINENESS[law]
    mesh = grid_mesh(np.linspace(INNER, OUTER, columns + 1), np.array([0.0, HEIGHT]))
    body = Body.at_rest(mesh.x, mesh.quads, np.append(mesh.loop, mesh.loop[0]), 20.0)
    body.velocity = np.column_stack([0.5 * (body.x[:, 0] - INNER), -body.x[:, 1]]) * SPEED / HEIGHT
    around = float(np.hypot(*np.diff(body.surface, axis=0).T).sum())
    return Simulation(
        body,
        [plate(0.0, 20.0), flat_punch(HEIGHT, SPEED, 20.0)],
        perfectly_plastic(YIELD_STRESS),
        np.linspace(0.0, around, 9),
        value if law == "mu" else CONSTANT_SHEAR,
        settings=Settings(penalty=2e5, shear_cap=1.0 if law == "mu" else value),
        control=StepControl(first=0.005 * HEIGHT, largest=increment * HEIGHT, slip=0.25),
        isothermal=True,
    )


def straight_readings(law: str, value: float) -> list[float]:
    """Return the decrease of the bore diameter in % at the reductions that the closed form has for this law.

    Raises Unfinished: the run stopped.
    """
    simulation = straight_ring(law, value)
    found = []
    for reduction in REDUCTIONS[: len(CURVES[law][value])]:
        if not simulation.advance_to(0.01 * reduction * HEIGHT):
            raise Unfinished(f"ring with one row, {law} {value:g}: {simulation.state.message}")
        radius = float(bore_profile(simulation.state.body.surface, 3)[1])
        found.append(100.0 * (1.0 - radius / INNER))
    return found


def as_closed_form() -> Outcome:
    """All readings of both laws."""
    ours = {law: {v: straight_readings(law, v) for v in curves} for law, curves in CURVES.items()}
    rows: list[Row] = [worst(law, ours[law], list(CURVES[law])) for law in CURVES]
    counts = [within(law, ours[law]) for law in CURVES]
    near = [within(law, ours[law], 1.0) for law in CURVES]
    text = (
        f"With a straight bore that does not harden, {sum(c.good for c in counts)} of {sum(c.all for c in counts)} readings "
        f"are within {POINTS:g} points of the {SOURCE.split(' (')[0]}, {sum(c.good for c in near)} within 1 point."
    )
    return Outcome(rows, text)
