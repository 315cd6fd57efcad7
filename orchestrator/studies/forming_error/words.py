"""The findings of the forming-error study in words, its table, and the paper's numbers beside ours."""

from __future__ import annotations

import numpy as np

from friction_models.common.wording import listed

from ...force_curves.metrics import percent as plain_percent
from .result import TAU_OVER_K, FormingErrors
from .rows import Change
from .study import FormingErrorStudy

#: Processes as readers know them.
PROCESS_TITLES = {"fre": "forward rod extrusion", "bce": "backward cup extrusion"}
#: Change of the error of the maximum force, and of its standard deviation, against constant friction.
PAPER_CHANGES = {"ffnn": (-0.58, -0.71), "polynomial": (-0.52, -0.84), "linear": (-0.52, -0.68)}
#: MARE of the maximum force with constant friction and its standard deviation, each with its uncertainty.
PAPER_CONSTANT = "13 ± 4 %", "19 ± 20 %"
#: Run time added by friction.
PAPER_TIMES = {"linear": "+18 %", "polynomial": "+18 %", "ffnn": "+61 %"}


def percent(value: float, std: float) -> str:
    """Return a share and its uncertainty in percent as a page shows it, ``12.3 ± 1.0 %``."""
    return plain_percent(value, std).replace("+-", "±")


def headline(errors: FormingErrors) -> str:
    """Return the best model and what it saves, in one line."""
    changes = [c for c in errors.changes() if not c.constant] or errors.changes()
    if not changes:
        return "Forming error of friction models"
    best = min(changes, key=lambda c: c.mare)
    parts = [_against(best, best.constant or "the mean of all constants")]
    # The mean hides how good the better constant is by itself.
    alone = [c for c in errors.changes() if c.constant and c.friction == best.friction]
    if not best.constant and alone:
        hardest = max(alone, key=lambda c: c.mare)
        parts.append(_against(hardest, f"{hardest.constant} alone"))
    return f"Error of the maximum force: {best.friction} is {', '.join(parts)}"


def _against(change: Change, what: str) -> str:
    return f"{abs(100 * change.mare):.0f} % {'below' if change.mare < 0 else 'above'} {what}"


def findings(errors: FormingErrors) -> list[str]:
    """Return what the study says, a sentence or two each."""
    return [*_nearest(errors), *_saved(errors), *_hardest(errors), *_outside(errors), *_cost(errors)]


def _trained(errors: FormingErrors) -> list[str]:
    return [f.label for f in errors.frictions if not f.constant]


def _nearest(errors: FormingErrors) -> list[str]:
    found = [s for f in errors.frictions if (s := errors.summary(f.label)) is not None]
    if not found:
        return []
    ordered = sorted(found, key=lambda s: s.max_force.mare)
    said = "; ".join(f"{s.friction} {percent(s.max_force.mare, s.max_force.mare_std)}" for s in ordered)
    lines = [f"Mean error of the maximum force over {found[0].levels}, nearest first: {said}."]
    if any(s.max_force.levels < s.planned for s in found):
        lines.append(
            f"{errors.missing} pairs have no result. So that all friction laws are compared over the same levels, levels that any "
            "of them lacks are left out of every mean here."
        )
    return lines


def _saved(errors: FormingErrors) -> list[str]:
    lines = []
    for constant in (f.label for f in errors.frictions if f.constant):
        changes = [c for c in errors.changes() if c.constant == constant]
        kinds = (
            ("less error with", [c for c in changes if c.mare < -2 * c.mare_std]),
            ("more with", [c for c in changes if c.mare > 2 * c.mare_std]),
            ("no clear difference with", [c for c in changes if abs(c.mare) <= 2 * c.mare_std]),
        )
        parts = [
            f"{what} {', '.join(f'{c.friction} ({signed(c.mare, c.mare_std)})' for c in some)}"
            for what, some in kinds
            if some
        ]
        if parts:
            lines.append(f"Against {constant}: {'; '.join(parts)}.")
    if lines:
        lines[0] += " Clear is a change of more than twice its uncertainty."
    return lines


def _hardest(errors: FormingErrors) -> list[str]:
    """Name the group with the largest errors of trained models, and where a model is no better than a constant."""
    worst: tuple[float, str] | None = None
    beaten = []
    for lubricant in errors.lubricants:
        for process in errors.processes:
            title = f"{PROCESS_TITLES.get(process, process)}, {lubricant}"
            found = {f: errors.summary(f.label, lubricant, process) for f in errors.frictions}
            mare = {f: s.max_force.mare for f, s in found.items() if s is not None}
            models = {f.label: e for f, e in mare.items() if not f.constant}
            constants = {f.label: e for f, e in mare.items() if f.constant}
            if not models:
                continue
            mean = float(np.mean(list(models.values())))
            if worst is None or mean > worst[0]:
                said = ", ".join(f"{name} {100 * e:.1f} %" for name, e in models.items())
                worst = mean, f"The trained models err most in {title}: {said}."
            if constants:
                best = min(constants, key=lambda name: constants[name])
                no_better = [f"{n} ({100 * e:.1f} %)" for n, e in models.items() if e >= constants[best]]
                if no_better:
                    beaten.append(
                        f"In {title} {', '.join(no_better)} {'is' if len(no_better) == 1 else 'are'} no better than "
                        f"{best} ({100 * constants[best]:.1f} %)."
                    )
    groups = len(errors.lubricants) * len(errors.processes)
    return [*([worst[1]] if worst and groups > 1 else []), *beaten]


def _outside(errors: FormingErrors) -> list[str]:
    parts = []
    for process in errors.processes:
        runs = [run for label in _trained(errors) for run in errors.of_group(label, None, process)]
        found = [(r.outside, r.distance) for r in runs if r.outside is not None and r.distance is not None]
        if found:
            share, distance = np.mean(found, axis=0)
            parts.append(
                f"{100 * share:.0f} % in {PROCESS_TITLES.get(process, process)} (median distance {distance:.2f} trained ranges)"
            )
    if not parts:
        return []
    return [
        f"Of the markers in contact, {' and '.join(parts)} have loads outside the trained domain, each in one of the five at "
        "least, and are clamped to it: there a model answers for the nearest loads that were tested. `study extrapolation` says "
        "what clamping does."
    ]


def _cost(errors: FormingErrors) -> list[str]:
    if not errors.runs:
        return []
    slowest = max(errors.runs, key=lambda r: r.friction_share)
    highest = max(errors.runs, key=lambda r: r.tau_over_k)
    side = "below" if highest.tau_over_k < TAU_OVER_K else "not below"
    return [
        f"Friction takes at most {100 * slowest.friction_share:.2f} % of the time of all else in a run ({slowest.friction}).",
        f"The friction stress reaches {100 * highest.tau_over_k:.0f} % of the shear yield stress ({highest.friction}), {side} the "
        f"{100 * TAU_OVER_K:.0f} % that the paper's runs stay below.",
    ]


def beside_paper(errors: FormingErrors) -> list[tuple[str, str, str]]:
    """Return (quantity, paper, here) of every number that the paper gives, and of ours that belong beside them."""
    rows: list[tuple[str, str, str]] = []
    constants = [f.label for f in errors.frictions if f.constant]
    for label in constants:
        summary = errors.summary(label)
        if summary is not None:
            force = summary.max_force
            mean = percent(force.mare, force.mare_std)
            rows.append((f"MARE of the maximum force, {label}", PAPER_CONSTANT[0], mean))
            spread = percent(force.spread, force.spread_std) if force.levels > 1 else "-"
            rows.append((f"its standard deviation over the levels, {label}", PAPER_CONSTANT[1], spread))
    for change in errors.changes():
        single = bool(change.constant) and len(constants) > 1
        paper = PAPER_CHANGES.get(change.friction)
        against = f"against {change.constant}" if change.constant else "against the mean of both constants"
        for name, number, ours in (
            ("MARE", 0, signed(change.mare, change.mare_std)),
            ("standard deviation", 1, signed(change.spread, change.spread_std)),
        ):
            said = "not named" if paper is None else f"{100 * paper[number]:+.0f} %"
            if single:
                said = "not by constant"
            rows.append((f"{change.friction}: change of the {name} {against}", said, ours))
    for label in _trained(errors):
        summary = errors.summary(label)
        if summary is not None:
            share = f"+{100 * summary.friction_share:.2f} %"
            rows.append((f"{label}: run time added by friction", PAPER_TIMES.get(label, "not named"), share))
    highest = max((r.tau_over_k for r in errors.runs), default=0.0)
    rows.append(("highest friction stress over shear yield stress", "below 60 %", f"{100 * highest:.0f} %"))
    return rows


def signed(value: float | None, std: float | None) -> str:
    """Return a change and its uncertainty in whole percent; ``"-"`` for none.

    Examples
    --------
    >>> signed(-0.25, 0.03), signed(None, None)
    ('-25 ± 3 %', '-')
    """
    if value is None or std is None:
        return "-"
    return f"{100 * value:+.0f} ± {100 * std:.0f} %"


def differs(study: FormingErrorStudy, errors: FormingErrors) -> list[str]:
    """Return what is not as in the paper."""
    points = []
    if study.virtual:
        T, speed = ({c[k] for c in study.plan.conditions} for k in (0, 1))
        points += [
            "Measurements are those of a virtual laboratory with laws of its own for the lubricants, so the size of an error says "
            "how well a model follows those laws, not the paper's lubricants.",
            "The virtual press forms with the same solver at a finer mesh, other flow stress, heat transfer and give of the press; solver "
            "errors that press and simulation share do not show.",
            "The paper's dies, press curves and factor levels are not at hand: geometry is a declared choice, and of the levels here only "
            f"{listed(f'{x:g}' for x in sorted(T & {20.0, 50.0, 100.0}))} °C and {listed(f'{x:g}' for x in sorted(speed & {5.0}))} mm/s are the paper's.",
        ]
    else:
        points.append(
            "Lubricants, tests, press and levels are the user's; errors compare with the paper's in kind, not in size."
        )
    other = [label for label in _trained(errors) if label not in PAPER_CHANGES]
    if other:
        points.append(
            f"The paper names {', '.join(PAPER_CHANGES)}; {', '.join(other)} {'is' if len(other) == 1 else 'are'} our choice."
        )
    return [
        *points,
        "Simulations are axisymmetric with 2D elements; the paper's are of other size, so shares of the run time compare only roughly.",
    ]


def text_table(errors: FormingErrors) -> str:
    """Return the summary as text: a block for each process and lubricant, and one over all."""
    lines = ["synthetic measurements"] if errors.synthetic else []
    width = max(len(f.label) for f in errors.frictions) + 2
    group: tuple[str, str] | None = None
    for s in errors.summaries():
        this = (s.lubricant or "all lubricants", PROCESS_TITLES.get(s.process or "", "all processes"))
        if this != group:
            group = this
            head = f"{this[1]}, {this[0]} ({s.levels})"
            lines += [
                "",
                head,
                f"{'':{width}}{'MARE max force':>18}{'std over levels':>18}{'MARE work':>18}{'tau/k':>8}{'friction time':>15}",
            ]
        cells = [
            plain_percent(s.max_force.mare, s.max_force.mare_std),
            plain_percent(s.max_force.spread, s.max_force.spread_std) if s.max_force.levels > 1 else "-",
            plain_percent(s.work.mare, s.work.mare_std),
        ]
        lines.append(
            f"{s.friction:{width}}"
            + "".join(f"{c:>18}" for c in cells)
            + f"{s.tau_over_k:8.2f}{100 * s.friction_share:13.2f} %"
        )
    if errors.missing:
        lines += [
            "",
            f"{errors.missing} runs are missing, see failed.json; errors are over levels that all laws have",
        ]
    return "\n".join(lines)
