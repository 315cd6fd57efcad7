"""Local loads at the markers: how they converge with the element size, and their error at the default mesh."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from friction_models.loads import LOAD_NAMES

from ..fe.mesh.shape import FloatArray
from ..processes.backward_cup_extrusion import BackwardCupExtrusion
from ..processes.base import FormingProcess
from ..processes.forward_rod_extrusion import ForwardRodExtrusion
from ..processes.specimen_upsetting import upset
from ..processes.upsetting import RingCompression
from .case import Case, Outcome, Row, case, finished

GROUP = "Local loads"
MU = 0.08
#: Element sizes over that of the default mesh.
SCALES = (2.0, 1.0, 0.5)
#: Allowed difference of v_rel, T, sigma_n, sd, psi from the run with the smallest elements [%]: root of the mean square over
#: that of the load; for T over that of the rise.
TOLERANCES = (5.0, 3.0, 4.0, 4.0, 2.0)
#: Share of the stroke after which markers count: before it the contact builds up.
SETTLED = 0.2
#: The twin's specimen: its default element size [mm], and forces over which its contact is averaged [N]: single nodes
#: that join the contact change its outermost ring.
SPECIMEN, FORCES = 0.6, np.linspace(230e3, 250e3, 21)
CASES: list[Case] = []
HEAD = "| load | 2 h, % | h, % | order | error at h, % |\n| --- | ---: | ---: | ---: | ---: |"


def differences(
    contacts: list[tuple[FloatArray, npt.NDArray[np.bool_]]], T_start: float, first: int
) -> FloatArray:
    """Return the difference of each run from the last one, shape (n_runs - 1, 5) [%].

    - `contacts`: loads, shape (n, n_points, 5), and markers in contact, shape (n, n_points), of each run.
    - `first`: step from which on they count.
    """
    start = np.array([0.0, T_start, 0.0, 0.0, 0.0])
    loads, active = contacts[-1]
    found = []
    for other, touching in contacts[:-1]:
        on = active & touching
        on[:first] = False
        off, size = (other - loads)[on], (loads - start)[on]
        found.append(100.0 * np.sqrt((off**2).mean(axis=0) / (size**2).mean(axis=0)))
    return np.array(found)


def order(coarse: float, usual: float) -> float:
    """Return the order p of an error C h^p from the differences of runs with 2 h and h from one with h / 2.

    (4^p - 1) / (2^p - 1) = 2^p + 1 is their quotient; NaN where they hardly fall: runs that differ
    by chance, at contacts that end within an element.
    """
    quotient = coarse / usual if usual > 0.0 else math.nan
    return math.log2(quotient - 1.0) if quotient > 2.0 else math.nan


def _converge(name: str, build: Callable[[float], FormingProcess], size: float, stroke: float) -> Outcome:
    contacts = []
    for scale in SCALES:
        process = build(scale * size)
        result = finished(process, process.run(MU, stroke))
        contacts.append((result.contact.loads, result.contact.active))
    found = differences(contacts, process.T_billet, int(SETTLED * len(contacts[-1][0])))
    source = f"elements of {SCALES[-1] * size:g} mm"
    rows, lines = [], []
    for k, (load, allowed) in enumerate(zip(LOAD_NAMES, TOLERANCES)):
        coarse, usual = found[:, k]
        what = f"{name}: {load} at the markers, elements of {size:g} mm, rms"
        rows.append(Row(what, "%", 0.0, source, float(usual), allowed, absolute=True))
        lines.append(_line(f"{name}, {load}", coarse, usual))
    words = (
        f"Markers of the {name}, elements of {2.0 * size:g} and {size:g} mm against {SCALES[-1] * size:g} mm, root of the "
        "mean square over that of the load (T: of the rise). Order and error at h follow from both; an error that falls to more "
        "than half fits no order (-)."
    )
    return Outcome(rows, "\n".join([words, "", HEAD, *lines]))


def _line(load: str, coarse: float, usual: float) -> str:
    """Return the line of a load in the table of `HEAD`."""
    p = order(coarse, usual)
    # The run with h / 2 is itself off by 2^-p of the error of the one with h.
    whole = usual * 2.0**p / (2.0**p - 1.0) if p > 0.0 else math.nan
    return f"| {load} | {coarse:.2f} | {usual:.2f} | {_shown(p)} | {_shown(whole)} |"


def _shown(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.2f}"


@case(CASES, "fre-local-loads", GROUP, fast=False)
def rod_loads() -> Outcome:
    """Forward rod extrusion 20 to 14.14 mm, 90 degrees, mu 0.08, 8 mm stroke, with tool heat."""
    return _converge("rod", lambda h: ForwardRodExtrusion(mesh_size=h), 0.4, 8.0)


@case(CASES, "bce-local-loads", GROUP, fast=False)
def cup_loads() -> Outcome:
    """Backward cup extrusion, billet 20 x 20 mm, punch 14.14 mm, mu 0.08, 6 mm, with tool heat."""
    return _converge("cup", lambda h: BackwardCupExtrusion(mesh_size=h), 0.35, 6.0)


@case(CASES, "ring-local-loads", GROUP, fast=False)
def ring_loads() -> Outcome:
    """Ring compression of the default ring to three quarters of its height, mu 0.08."""
    usual = RingCompression().mesh_size
    return _converge("ring", lambda h: RingCompression(mesh_size=h), usual, 0.25 * RingCompression().height)


@case(CASES, "specimen-local-loads", GROUP, fast=False)
def specimen_loads() -> Outcome:
    """Specimen of a sliding compression test, 15 x 15 mm, free punch, mu 0.1."""
    # By radius: where the side folds onto the plate, in the outer tenth, a ring of the contact is hardly wider than an element.
    runs = [upset(force=FORCES, mesh_size=scale * SPECIMEN, mu=0.1) for scale in SCALES]
    fine = runs[-1]
    inside = fine.radius_fraction <= 0.9
    source = f"elements of {SCALES[-1] * SPECIMEN:g} mm"
    rows, lines = [], []
    for load, allowed in (("sigma_n", 4.0), ("psi", 2.0)):
        known = getattr(fine, load).mean(axis=0)
        for where, part in (("within 0.9 of the radius", inside), ("in the outer tenth", ~inside)):
            weight, size = fine.radius_fraction[part], known[part]
            coarse, usual = (
                100.0
                * math.sqrt(
                    (weight * (getattr(r, load).mean(axis=0)[part] - size) ** 2).sum()
                    / (weight * size**2).sum()
                )
                for r in runs[:-1]
            )
            lines.append(_line(f"{load} {where}", coarse, usual))
            if part is inside:
                what = f"specimen: {load} {where}, elements of {SPECIMEN:g} mm, rms"
                rows.append(Row(what, "%", 0.0, source, usual, allowed, absolute=True))
    usual_run = runs[-2]
    for what, unit, ours, reference, allowed in (
        ("mean psi", "", usual_run.psi_mean, fine.psi_mean, 2.0),
        ("contact radius", "mm", usual_run.contact_radius, fine.contact_radius, 1.0),
    ):
        name = f"specimen: {what}, elements of {SPECIMEN:g} mm"
        rows.append(Row(name, unit, float(reference.mean()), source, float(ours.mean()), allowed))
    words = (
        f"Specimen on the plate, mean of {len(FORCES)} forces from {1e-3 * FORCES[0]:g} to {1e-3 * FORCES[-1]:g} kN, elements of "
        f"{2.0 * SPECIMEN:g} and {SPECIMEN:g} mm against {SCALES[-1] * SPECIMEN:g} mm, root of the mean square by area over "
        "that of the load."
    )
    return Outcome(rows, "\n".join([words, "", HEAD, *lines]))
