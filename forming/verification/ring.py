"""Ring compression 6:3:2: CalculiX, and calibration curves in closed form."""

from __future__ import annotations

from collections.abc import Mapping

from ..friction_input import CONSTANT_SHEAR
from ..ring import RingCompression
from .calculix import Compression
from .case import Case, Outcome, Row, Unfinished
from .peer import Kept, peer, peer_row
from .runs import account_rows, finished, rate_independent

GROUP = "Ring compression"
REDUCTIONS = (10, 20, 30, 40, 50, 60)
#: Decrease of the bore diameter of a ring 6:3:2 in % at `REDUCTIONS` of the height: equilibrium solution after
#: Hawkyard and Johnson with the velocity field of Avitzur, integrated step by step; the bore stays straight,
#: nothing hardens. First Coulomb's law tau = min(mu p, k), up to 50 %, then tau = m k.
BY_MU = {
    0.02: (-4.68, -10.01, -16.12, -23.14, -31.13),
    0.04: (-3.91, -8.13, -12.56, -16.95, -20.51),
    0.055: (-3.30, -6.65, -9.78, -12.12, -12.43),
    0.08: (-2.23, -4.04, -4.88, -4.27, -1.61),
    0.10: (-1.32, -1.81, -1.27, 0.63, 5.09),
    0.15: (0.55, 1.84, 4.31, 8.77, 16.89),
    0.20: (1.50, 3.95, 7.89, 14.31, 25.38),
    0.30: (2.84, 6.92, 12.94, 22.25, 37.75),
    0.40: (3.67, 8.70, 15.80, 26.36, 43.60),
}
BY_M = {
    0.0: (-5.41, -11.80, -19.52, -29.10, -41.42, -58.11),
    0.05: (-4.38, -9.29, -14.78, -20.87, -27.35, -33.39),
    0.10: (-3.35, -6.78, -10.11, -12.88, -13.99, -12.25),
    0.15: (-2.29, -4.24, -5.40, -5.18, -3.22, 2.24),
    0.20: (-1.19, -1.61, -1.11, 0.62, 4.56, 12.89),
    0.30: (0.51, 1.69, 3.90, 7.82, 14.75, 27.63),
    0.40: (1.36, 3.56, 7.03, 12.58, 21.78, 38.41),
    0.60: (2.55, 6.16, 11.40, 19.28, 31.94, 55.13),
    0.80: (3.33, 7.89, 14.33, 23.87, 39.18, 68.93),
    1.00: (3.89, 9.13, 16.45, 27.26, 44.75, 82.60),
}
#: Above these frictions the bore bulges at 50 % by more than the tolerance (middle against straight bore of equal
#: volume), and the straight bore of the closed form is no reference any more.
STRAIGHT_UP_TO = {"mu": 0.15, "m": 0.30}
#: Allowed difference of the decrease of the bore [% of the first diameter].
POINTS = 3.0
#: Another published finite element study, an aluminium at 300 degC between tools at 250 degC, 50 %, by m; it says
#: -40.33 where volume alone gives -41.42.
PUBLISHED_BY_M = {0.0: -40.33, 0.10: -15.10, 0.30: 14.00, 0.40: 24.46}
#: Above 1 / sqrt(3): with it CalculiX sticks wherever the pressure is that of yielding.
STICKING = 0.6
SOURCE = "equilibrium solution (Hawkyard, Johnson), bore stays straight"
#: Kept from CalculiX, for where it is not installed.
KEPT = {
    0.1: Kept("2.20", "2026-11-21", {"force": 129.82, "bore_middle": 2.775}),
    0.2: Kept("2.20", "2026-11-21", {"bore_decrease": 32.57}),
    0.3: Kept("2.20", "2026-11-21", {"bore_decrease": 42.47}),
    0.4: Kept("2.20", "2026-11-21", {"bore_decrease": 45.86}),
    STICKING: Kept("2.20", "2026-11-21", {"bore_decrease": 47.60}),
}


def ring(shear_factor: float = 1.0, mesh_size: float = 0.25) -> RingCompression:
    """Return the ring of all cases: diameters 12 and 6 mm, height 4 mm, isothermal, rate-independent."""
    return RingCompression(
        mesh_size=mesh_size, shear_factor=shear_factor, isothermal=True, material=rate_independent()
    )


def in_calculix(mu: float) -> Compression:
    """Return the same ring for CalculiX."""
    return Compression(outer=6.0, inner=3.0, height=4.0, mu=mu, columns=8, rows=6)


def with_calculix() -> list[Row]:
    """Ring at mu 0.1, 50 %: force and bore."""
    process = ring()
    result = finished(process, process.run(0.1, 2.0))
    other = peer(in_calculix(0.1), KEPT[0.1])
    middle = float(process.bore_profile(201)[100])
    return [
        peer_row("force at 50 %", "kN", other, "force", float(result.force[-1]), 1.0),
        peer_row("bore radius at middle height", "mm", other, "bore_middle", middle, 1.0),
        *account_rows(result),
    ]


def high_friction_with_calculix() -> Outcome:
    """Bore at 50 % where friction is so high that the side folds onto the tools."""
    rows = []
    lines = ["| mu | ours | CalculiX | closed form |", "| ---: | ---: | ---: | ---: |"]
    for mu in (0.2, 0.3, 0.4):
        other = peer(in_calculix(mu), KEPT[mu])
        ours = readings(ring(), mu)[-1]
        lines.append(f"| {mu:g} | {ours:.1f} | {other.values['bore_decrease']:.1f} | {BY_MU[mu][-1]:.1f} |")
        rows.append(
            peer_row(
                f"bore decrease at 50 %, mu {mu:g}", "points", other, "bore_decrease", ours, POINTS, True
            )
        )
    # Coulomb's law with mu p above the shear yield stress everywhere sticks, as constant shear does at m = 1.
    other = peer(in_calculix(STICKING), KEPT[STICKING])
    sticking = readings(ring(1.0), CONSTANT_SHEAR)[-1]
    rows.append(
        peer_row(
            f"bore decrease at 50 %, sticking: m 1 (CalculiX: mu {STICKING:g})",
            "points",
            other,
            "bore_decrease",
            sticking,
            POINTS,
            True,
        )
    )
    lines.append(f"| m 1 | {sticking:.1f} | {other.values['bore_decrease']:.1f} | {BY_M[1.0][4]:.1f} |")
    title = "Decrease of the bore in % at 50 %, high friction:"
    return Outcome(rows, title + "\n\n" + "\n".join(lines))


def readings(process: RingCompression, mu: float, count: int = 5) -> list[float]:
    """Return the decrease of the bore diameter in % at the first `count` of `REDUCTIONS`.

    Raises
    ------
    Unfinished
        The run stopped.
    """
    process.start(mu)
    found = []
    for reduction in REDUCTIONS[:count]:
        if not process.advance(0.01 * reduction * process.height - process.stroke):
            raise Unfinished(f"{process.name}, mu {mu:g}, m {process.shear_factor:g}: {process.message}")
        found.append(-100.0 * process.bore_change)
    return found


def calibration_by_mu() -> Outcome:
    """Calibration curves for Coulomb's law."""
    return _calibration("mu", BY_MU, {mu: readings(ring(), mu) for mu in BY_MU})


def calibration_by_m() -> Outcome:
    """Calibration curves for constant shear."""
    ours = {m: readings(ring(m), CONSTANT_SHEAR, len(REDUCTIONS)) for m in BY_M}
    outcome = _calibration("m", BY_M, ours)
    pairs = [
        f"m {m:g}: {ours[m][REDUCTIONS.index(50)]:.1f} / {value:.1f}" for m, value in PUBLISHED_BY_M.items()
    ]
    other = (
        "For comparison, not judged: ours / another finite element study (aluminium at 300 degC, tools at 250 degC, "
        f"which gives -40.3 where volume alone gives -41.4), 50 %: {', '.join(pairs)}."
    )
    return Outcome(outcome.rows, f"{outcome.details}\n\n{other}")


def _calibration(
    law: str, closed: Mapping[float, tuple[float, ...]], ours: Mapping[float, list[float]]
) -> Outcome:
    limit = STRAIGHT_UP_TO[law]
    low, high = [v for v in closed if v <= limit], [v for v in closed if v > limit]
    judge = "judges here" if law == "mu" else "judges the end of the range, m 1, because it has no such law"
    note = (
        "at 50 % the bore bulges by more than the tolerance, which the closed form leaves out; CalculiX departs "
        f"from it as well and {judge}: ring-calculix-high"
    )
    worst = _worst(law, low, closed, ours)
    beyond = _worst(law, high, closed, ours, standing="not judged", note=note)
    reductions = REDUCTIONS[: len(closed[low[0]])]
    header = f"| {law} | " + " | ".join(f"{r} %" for r in reductions) + " |"
    lines = [header, "| ---: |" + " ---: |" * len(reductions)]
    for value in closed:
        cells = [f"{a:.1f} / {b:.1f}" for a, b in zip(ours[value], closed[value])]
        lines.append(f"| {value:g} | " + " | ".join(cells) + " |")
    title = f"Decrease of the bore in % by {law} and reduction of height, ours / closed form:"
    return Outcome([worst, beyond], title + "\n\n" + "\n".join(lines))


def _worst(
    law: str,
    values: list[float],
    closed: Mapping[float, tuple[float, ...]],
    ours: Mapping[float, list[float]],
    **more: str,
) -> Row:
    """Return the row of the reading that deviates most."""
    places = [(value, k) for value in values for k in range(len(closed[value]))]
    value, k = max(places, key=lambda at: abs(ours[at[0]][at[1]] - closed[at[0]][at[1]]))
    return Row(
        f"bore decrease, {law} {min(values):g} to {max(values):g}, worst of {len(places)} readings "
        f"({law} {value:g}, {REDUCTIONS[k]} %)",
        "points",
        closed[value][k],
        SOURCE,
        ours[value][k],
        POINTS,
        absolute=True,
        **more,  # type: ignore[arg-type]
    )


CASES = (
    Case(
        "ring-calculix",
        GROUP,
        "Ring 12 x 6 x 4 mm, 50 %, mu 0.1, isothermal; flow curve held at 0.5/s in both programs.",
        with_calculix,
    ),
    Case(
        "ring-calculix-high",
        GROUP,
        "The same ring at mu 0.2, 0.3, 0.4 and sticking: the decrease of the bore (straight bore of equal volume).",
        high_friction_with_calculix,
        fast=False,
    ),
    Case(
        "ring-calibration-mu",
        GROUP,
        "The same ring, Coulomb's law with the cap k, read at 10 to 50 % reduction.",
        calibration_by_mu,
    ),
    Case(
        "ring-calibration-m",
        GROUP,
        "The same ring, constant shear tau = m k, read at 10 to 60 % reduction.",
        calibration_by_m,
    ),
)
