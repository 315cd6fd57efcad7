"""``--target lsdyna``: user friction USRFRC of LS-DYNA, Fortran around the C export.

USRFRC is called once a cycle for the nodes of an interface that are in contact. Temperature is not among the arguments as we know
them, and no public text shows the list; the README says so.
"""

from __future__ import annotations

import numpy as np

from ..interface.friction_source import FrictionSource
from .common import Files, Reference, template, test_box
from .host_units import HostUnits, host_units
from .ufric_target import depends_on, fortran_number


def history(source: FrictionSource, units: HostUnits, nodes: int = 4, cycles: int = 8) -> str:
    """Return the cycles of the self-test.

    First the system variables; then for each cycle dt, the number of nodes and the temperature, and a row a node: number, area of
    the node (0: not given), of the segment, normal force, relative displacement (3), normal (3), expected mu; -1 where the
    coefficients must stay.
    """
    reference = Reference(source)
    lower, upper = test_box(source)
    rng = np.random.default_rng(25)
    sd, first = np.zeros(nodes), np.zeros(nodes)
    state = reference.model.start_state(nodes)
    rows = [" ".join(fortran_number(p.start) for p in source.system)]
    for cycle in range(1, cycles + 1):
        dt, T = float(rng.uniform(1e-4, 1e-3)), float(rng.uniform(lower[1], upper[1]))
        warm = units.to_host(np.array([[1.0, T, 1.0, 0.0, 1.0]]))[0, 1]
        rows.append(f"{fortran_number(dt / units.time)} {nodes} {fortran_number(float(warm))}")
        for k in range(nodes):
            v, _, sigma = rng.uniform(lower[:3], upper[:3])
            area = float(rng.uniform(0.5, 0.6) * (1.0 + 0.2 * cycle))
            normal = rng.normal(size=3)
            normal /= np.linalg.norm(normal)
            along = np.cross(normal, rng.normal(size=3))
            along /= np.linalg.norm(along)
            expected, force = -1.0, 0.0 if k == 1 and cycle in (3, 4) else float(sigma * area)
            if force > 0.0:
                first[k] = first[k] or area
                sd[k] += v * dt
                psi = 1.0 if k == 3 else area / first[k]
                loads = np.array([[v, T, sigma, sd[k], psi]])
                if source.states:
                    state[k : k + 1] = reference.step(loads, state[k : k + 1], dt)
                expected = float(reference.mu(loads, state[k : k + 1] if source.states else None)[0])
            place = area / units.length**2
            areas = (0.0, place) if k == 3 else (place, 99.0)
            slip = (v * dt * along + 0.01 * normal) / units.length
            numbers = (*areas, force / units.pressure / units.length**2, *slip, *normal, expected)
            rows.append(f"{11 * k + 3} " + " ".join(fortran_number(float(x)) for x in numbers))
    return "\n".join(rows) + "\n"


def lsdyna_files(
    source: FrictionSource,
    prefix: str,
    values: dict[str, str],
    units: object = "tonne-mm-s",
    temperature: object = None,
) -> Files:
    """Return what an LS-DYNA export has beside the files of `subroutine_files`; `units`, `temperature` are the deck's."""
    host = host_units(units, temperature)
    values |= host.fortran() | {"DEPENDS": ", ".join(depends_on(source)) or "none of the loads"}
    return {
        "lsdyna.f": template("lsdyna.f", values),
        "selftest.f90": template("lsdyna_selftest.f90", values),
        "selftest.txt": history(source, host),
    }
