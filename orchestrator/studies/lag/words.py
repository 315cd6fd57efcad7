"""The findings of the study ``lag`` in words, and its table."""

from __future__ import annotations

from .result import LagNumbers


def headline(numbers: LagNumbers) -> str:
    """Return what the lag changes at most, in one line."""
    found = [
        (r["step_mm"], lag)
        for r in numbers["rows"]
        if r["mode"] == "gauss_seidel" and (lag := r.get("lag")) is not None
    ]
    if not found:
        return "One-step lag: no pair of runs to compare"
    work = max(abs(lag["work_pct"]) for _, lag in found)
    force = max(abs(lag["rms_pct"]) for _, lag in found)
    steps = [step for step, _ in found]
    return (
        f"One-step lag changes the forming work by at most {work:.2g} % and the force by {force:.2g} % (rms) "
        f"at steps of {min(steps):g} to {max(steps):g} mm"
    )


def text_table(numbers: LagNumbers) -> str:
    """Return the summary as text."""
    lines = ["friction models trained on synthetic data"] if numbers["synthetic"] else []
    lines.append(
        f"{'process':8}{'model':20}{'mode':14}{'work %/mm':>11}{'force %/mm':>12}{'rms %/mm':>10}{'mu /mm':>10}{'cost':>7}{'failed':>8}"
    )
    for entry in numbers["summary"]:
        head = f"{entry['process']:8}{entry['model']:20}{entry['mode']:14}"
        if not entry["runs"]:
            lines.append(f"{head}{'-':>11}{'-':>12}{'-':>10}{'-':>10}{'-':>7}{entry['failed']:>8}")
            continue
        cost = entry["timing"].get("relative")
        lines.append(
            f"{head}{entry['work_pct_per_mm']:>+11.3f}{entry['max_force_pct_per_mm']:>+12.3f}{entry['rms_pct_per_mm']:>10.3f}"
            f"{entry['mu_mean_per_mm']:>10.5f}{'-' if cost is None else f'{cost:.1f}x':>7}{entry['failed']:>8}"
        )
    lines.append(
        "jacobi and gauss_seidel: against the iterated run of the same step; iterated: against that of the finest"
    )
    return "\n".join(lines)
