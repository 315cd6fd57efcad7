"""``--target vfric``: user subroutines VFRIC and VFRICTION of Abaqus/Explicit, Fortran around the C export.

Argument lists: Abaqus User Subroutines Reference Guide, 1.2 (VFRIC for contact pairs, VFRICTION for general contact).
Both must give the whole tangential force and keep state variables with the contact point.
"""

from __future__ import annotations

import numpy as np

from ...interface.friction_source import FrictionSource
from ..common import Files, Reference, template, test_box
from .ufric_target import depends_on, fortran_number


def history(source: FrictionSource, points: int = 4, increments: int = 8) -> str:
    """Return the increments of the self-test.

    First the properties; then for each increment its number, dt and number of points, and a row for each
    point: number, slip (3), normal force, area, both temperatures, expected mu. A point's normal force of
    0 is a point that just lost contact.
    """
    reference = Reference(source)
    lower, upper = test_box(source)
    rng = np.random.default_rng(23)
    sd, first = np.zeros(points), np.zeros(points)
    state = reference.model.start_state(points)
    rows = [" ".join(fortran_number(x) for x in (1.0, 20.0, *(p.start for p in source.system)))]
    for inc in range(1, increments + 1):
        dt = float(rng.uniform(1e-4, 1e-3))
        present = [k for k in range(points) if not (k == 1 and inc in (3, 4))]
        rows.append(f"{inc} {fortran_number(dt)} {len(present)}")
        for k in present:
            v, T, sigma = rng.uniform(lower[:3], upper[:3])
            area = float(rng.uniform(0.5, 0.6) * (1.0 + 0.2 * inc))
            angle, apart = rng.uniform(0.0, 2.0 * np.pi), float(rng.uniform(-5.0, 5.0))
            slip = v * dt * np.array([np.cos(angle), np.sin(angle), 0.0])
            normal = 0.0 if k == 2 and inc == 5 else float(sigma * area)
            expected = 0.0
            if normal > 0.0:
                first[k] = first[k] or area
                speed = float(np.sqrt((slip**2).sum())) / dt
                sd[k] += speed * dt
                loads = np.array([[speed, T, normal / area, sd[k], area / first[k]]])
                state[k : k + 1] = reference.step(loads, state[k : k + 1], dt)
                expected = float(reference.mu(loads, state[k : k + 1])[0])
            numbers = (*slip, normal, area, T - apart, T + apart, expected)
            rows.append(f"{k + 1} " + " ".join(fortran_number(float(x)) for x in numbers))
    return "\n".join(rows) + "\n"


def vfric_files(source: FrictionSource, prefix: str, values: dict[str, str]) -> Files:
    """Return what a VFRIC export has beside the C text and the documents."""
    props = ["1.", *(f"{p:g}" for p in (20.0, *(p.start for p in source.system)))]
    values |= {
        "DEPVAR": str(3 + len(source.states)),
        "PROPERTIES": str(len(props)),
        "PROPS_LINE": ", ".join(props),
        "DEPENDS": ", ".join(depends_on(source)) or "none of the loads",
        "TOLERANCE": "1d-12",
    }
    return {
        "vfric.f": template("vfric.f", values),
        "selftest/selftest.f90": template("vfric_selftest.f90", values),
        "selftest/selftest.txt": history(source),
        "selftest/vaba_param.inc": template("vaba_param.inc", values),
    }
