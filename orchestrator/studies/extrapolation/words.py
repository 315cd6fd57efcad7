"""The findings of the study ``extrapolation`` in words, and its table."""

from __future__ import annotations

from .result import ExtrapolationNumbers
from .study import DATA_KINDS


def headline(numbers: ExtrapolationNumbers) -> str:
    """Return how much of the friction work is done beyond the trained domain, in one line."""
    shares = {
        kind: [100 * r["outside_work"] for r in numbers["runs"] if r["data"] == kind and "outside_work" in r]
        for kind in DATA_KINDS
    }
    if not all(shares.values()):
        return "Friction beyond the trained domain"
    whole, reduced = (f"{min(s):.0f} to {max(s):.0f} %" for s in shares.values())
    return f"Outside the trained domain: {whole} of the friction work with all tests, {reduced} with the reduced ones"


def text_table(numbers: ExtrapolationNumbers) -> str:
    """Return one line a run as text."""
    lines = ["friction models trained on synthetic data"] if numbers["synthetic"] else []
    lines.append(
        f"{'level':20}{'model':20}{'data':9}{'rule':13}{'outside':>9}{'by work':>9}{'distance':>10}{'mu':>18}{'max force':>11}{'work':>9}"
    )
    for run in numbers["runs"]:
        head = f"{run['level']:20}{run['model']:20}{run['data']:9}{run['rule']:13}"
        if "states" not in run:
            lines.append(f"{head}  {run['failed'] or 'no contact'}")
            continue
        mu = f"{run['mu']['low']:.3f} - {run['mu']['high']:.3f}"
        lines.append(
            f"{head}{100 * run['outside']:>7.0f} %{100 * run['outside_work']:>7.0f} %{run['distance']['median']:>10.3f}{mu:>18}"
            f"{run['max_force_kN']:>8.1f} kN{run['work_J']:>7.0f} J"
            + (f"  broke off at {run['stroke_mm']:.1f} mm" if run["failed"] else "")
        )
    return "\n".join(lines)
