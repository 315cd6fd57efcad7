"""``--target ufric``: user subroutine UFRIC of Marc and Simufact Forming, Fortran around the C export.

The calling sequence is the one of Marc's Volume D, ``UFRIC(MIBODY, X, F, V, TEMP, YIEL, FRIC, TIME, INC, NSURF)``:
every contact point in every iteration. Sliding distance is not among the arguments and is integrated; the surface
expansion is not either and is left to the user.
"""

from __future__ import annotations

import numpy as np

from friction_models.loads import LOAD_NAMES

from ...interface.friction_source import FrictionSource
from ..common import Files, Reference, one_line, template, test_box


def fortran_number(value: float) -> str:
    """Return a double precision constant that is read back as exactly `value`.

    Examples
    --------
    >>> fortran_number(0.5), fortran_number(1e-30)
    ('5.00000000000000000d-01', '1.00000000000000008d-30')
    """
    return format(value, ".17e").replace("e", "d")


def depends_on(source: FrictionSource) -> list[str]:
    """Return the loads that mu or the memory reacts to between the ends of the domain, found by trying.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> depends_on(read_source(ConstantFriction(mu=0.1)))
    []
    """
    reference = Reference(source)
    lower, upper = test_box(source)
    points = np.random.default_rng(21).uniform(lower, upper, size=(64, len(LOAD_NAMES)))

    def answer(at: np.ndarray) -> np.ndarray:
        state = reference.step(at, reference.model.start_state(len(at)), 0.1)
        return np.column_stack([reference.mu(at, state), state])

    found = []
    for column, name in enumerate(LOAD_NAMES):
        ends = []
        for value in (lower[column], upper[column]):
            moved = points.copy()
            moved[:, column] = value
            ends.append(answer(moved))
        if not np.array_equal(ends[0], ends[1]):
            found.append(name)
    return found


def system_lines(source: FrictionSource) -> str:
    """Return the Fortran statements that give the system variables their start values."""
    lines = [
        f"c     {one_line(f'{p.name} [{p.unit}]')[:60]}\n      values({i + 1}) = {fortran_number(p.start)}\n"
        for i, p in enumerate(source.system)
    ]
    return "".join(lines) or "      values(1) = 0.0d0\n"


def history(source: FrictionSource, points: int = 3, increments: int = 8) -> str:
    """Return the calls of the self-test: node, increment, time, X(2), V(2), TEMP(1), F(1), expected mu.

    A row whose expected mu is -1 is an iteration before the last one; point 2 has no contact for a while.
    """
    reference = Reference(source)
    lower, upper = test_box(source)
    rng = np.random.default_rng(22)
    sd, state = np.zeros(points), reference.model.start_state(points)
    time, rows = 0.0, []
    for inc in range(1, increments + 1):
        dt = float(rng.uniform(2e-3, 1e-2))
        cut = inc == 4
        for tried in [2.0 * dt, dt] if cut else [dt]:
            for iteration in range(2):
                final = tried == dt and iteration == 1
                for k in range(points):
                    if k == 1 and inc in (3, 4):
                        continue
                    v, T, sigma = rng.uniform(lower[:3], upper[:3])
                    angle = rng.uniform(0.0, 2.0 * np.pi)
                    parts = v * np.array([np.cos(angle), np.sin(angle)])
                    expected = -1.0
                    if final:
                        speed = float(np.sqrt((parts**2).sum()))
                        sd[k] += speed * dt
                        loads = np.array([[speed, T, sigma, sd[k], 1.0]])
                        state[k : k + 1] = reference.step(loads, state[k : k + 1], dt)
                        expected = float(reference.mu(loads, state[k : k + 1])[0])
                    numbers = (time + tried, 10.0 * k, 0.0, *parts, T, sigma, expected)
                    rows.append(f"{k + 1} {inc} " + " ".join(fortran_number(float(x)) for x in numbers))
        time += dt
    return "\n".join(rows) + "\n"


def ufric_files(source: FrictionSource, prefix: str, values: dict[str, str]) -> Files:
    """Return what a UFRIC export has beside the C text and the documents."""
    depends = depends_on(source)
    values |= {
        "PSI_MATTERS": ".true." if "psi" in depends else ".false.",
        "DEPENDS": ", ".join(depends) or "none of the loads",
        "SYSTEM_LINES": system_lines(source),
    }
    return {
        "ufric.f": template("ufric.f", values),
        "selftest.f90": template("ufric_selftest.f90", values),
        "selftest.txt": history(source),
    }
