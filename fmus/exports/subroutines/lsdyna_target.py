"""``--target lsdyna``: user friction USRFRC of LS-DYNA, Fortran around the C export.

USRFRC is called once a cycle for the nodes of an interface that are in contact. It makes the friction force itself: the penalty
force of the slip, limited to mu times the normal force. The argument list is that of dyn21.f in object versions that users
published (the one for shared memory).
"""

from __future__ import annotations

import numpy as np

from friction_models.common import InputError

from ...interface.friction_source import FrictionSource
from ..common import Files, Reference, template, test_box
from ..host_units import HostUnits, host_units
from .ufric_target import depends_on, fortran_number


def history(
    source: FrictionSource, units: HostUnits, thermal: bool = True, nodes: int = 4, cycles: int = 8
) -> str:
    """Return the cycles of the self-test.

    First the system variables; then for each cycle dt, the number of nodes, the temperature in UA and the penalty stiffness, and a
    row a node: number, area, normal force (negative in contact), relative displacement (3), normal (3), temperatures of the node
    and of the segment, expected mu. In cycle 2 the stiffness is so low that all nodes stick.
    """
    reference = Reference(source)
    lower, upper = test_box(source)
    rng = np.random.default_rng(25)
    sd, first = np.zeros(nodes), np.zeros(nodes)
    state = reference.model.start_state(nodes)
    rows = [" ".join(fortran_number(p.start) for p in source.system)]
    for cycle in range(1, cycles + 1):
        dt, common = float(rng.uniform(1e-4, 1e-3)), float(rng.uniform(lower[1], upper[1]))
        warm = units.to_host(np.array([[1.0, common, 1.0, 0.0, 1.0]]))[0, 1]
        own, slopes = [], []
        for k in range(nodes):
            v, T, sigma = rng.uniform(lower[:3], upper[:3])
            T = T if thermal else common
            area = float(rng.uniform(0.5, 0.6) * (1.0 + 0.2 * cycle))
            normal = rng.normal(size=3)
            normal /= np.linalg.norm(normal)
            along = np.cross(normal, rng.normal(size=3))
            along /= np.linalg.norm(along)
            expected, force = 0.0, 0.0 if k == 1 and cycle in (3, 4) else float(sigma * area)
            if force > 0.0:
                first[k] = first[k] or area
                sd[k] += v * dt
                loads = np.array([[v, T, sigma, sd[k], area / first[k]]])
                state[k : k + 1] = reference.step(loads, state[k : k + 1], dt)
                expected = float(reference.mu(loads, state[k : k + 1])[0])
            slip = (v * dt * along + 0.01 * normal) / units.length
            t = units.to_host(np.array([[v, T, sigma, 0.0, 1.0]]))[0, 1]
            place, push = area / units.length**2, -force / units.pressure / units.length**2
            if expected > 0.0:
                slopes.append(-expected * push / (v * dt / units.length))
            numbers = (place, push, *slip, *normal, t - 5.0, t + 5.0, expected)
            own.append(f"{11 * k + 3} " + " ".join(fortran_number(float(x)) for x in numbers))
        stiff = 0.5 * min(slopes) if cycle == 2 and slopes else 1e12
        head = (fortran_number(float(x)) for x in (warm, stiff))
        rows += [f"{fortran_number(dt / units.time)} {nodes} {' '.join(head)}", *own]
    return "\n".join(rows) + "\n"


def lsdyna_files(
    source: FrictionSource,
    prefix: str,
    values: dict[str, str],
    units: object = "tonne-mm-s",
    temperature: object = None,
    thermal: object = True,
) -> Files:
    """Return what an LS-DYNA export has beside the C text and the documents.

    `units` and `temperature` are those of the deck; `thermal` says whether the job computes temperatures.
    """
    if not isinstance(thermal, bool):
        raise InputError(f"thermal = {thermal!r}, allowed: true, false")
    host = host_units(units, temperature)
    values |= host.fortran() | {
        "DEPENDS": ", ".join(depends_on(source)) or "none of the loads",
        "HISTORY": str(3 + len(source.states)),
        "THERMAL": ".true." if thermal else ".false.",
        "T_SOURCE": "mean of TEMP at the node and on the segment beneath it"
        if thermal
        else "the number UA(1)",
    }
    return {
        "lsdyna.f": template("lsdyna.f", values),
        "selftest.f90": template("lsdyna_selftest.f90", values),
        "selftest.txt": history(source, host, thermal),
    }
