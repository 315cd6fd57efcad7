"""`refine`: add effects to a model, fit base and effects together, confirm on whole tests that were held out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NotRequired, TypedDict

import numpy as np
import pandas as pd
from sklearn.base import clone

from ..common import InputError
from ..common.processes.one_blas_thread import one_blas_thread
from ..common.processes.pool import Progress
from ..effects import make_effect
from ..effects.base import Effect
from ..estimation.campaign.binning import BinnedTests, prepare
from ..estimation.campaign.metadata import with_all_metadata
from ..estimation.noise.odd_tests import first_names
from ..families.composed import ComposedFriction
from ..families.refinement_history import rise_text
from ..families.registry import make_model
from ..loads import FloatArray, TriboLoads
from ..models.base import FrictionModel
from ..models.domain import Domain
from ..models.measures import error_measures
from .judge.unseen_tests import folds_of, names_of, predicted_unseen
from .judged_tests import tests_beside, without_odd
from .resampling import before_and_after

#: An addition is refused when the held-out error rises by more than this, and clearly so (paired over tests).
WORSE = 1.01
#: An error that does not fall below this share of the earlier one is said to be no better.
BETTER = 0.995


class Addition(TypedDict):
    """One entry of ``error_history_``: what was added, and the errors before and after on tests that the fit did not see.

    Examples
    --------
    Six tests in which friction falls with temperature, as a constant with the effect describes and a constant does not:

    >>> from friction_models.discovery import refine
    >>> steps = [(k, j) for k in range(6) for j in range(8)]
    >>> data = pd.DataFrame({"test_id": [f"test{k}" for k, _ in steps], "sd": [2.0 * j for _, j in steps]})
    >>> data = data.assign(T=[20.0 + 10 * j for _, j in steps], mu=[0.1 - 0.002 * j + 1e-5 * k for k, j in steps])
    >>> model = refine(data, model="constant", add="thermal_softening")
    >>> model.name
    'constant + thermal_softening'
    >>> addition = model.error_history_[-1]
    >>> addition["judged_by"]
    '6-fold cross-validation by whole tests'
    >>> round(addition["before"]["mae"], 4), round(addition["after"]["mae"], 4)
    (0.004, 0.0001)
    """

    added: list[str]
    judged_by: str
    corrects_data: list[str]
    before: dict[str, float]
    after: dict[str, float]
    #: 95 % intervals of the errors ``before`` and ``after`` and of the ``fall``, as `compare` finds them; not in older files.
    intervals: NotRequired[dict[str, dict[str, list[float] | None]]]
    #: Whether the RMSE fell by more than chance.
    clear: NotRequired[bool]
    #: Whether the RMSE rose by more than chance; not in older files.
    rose: NotRequired[bool]


@one_blas_thread()
def refine(
    data: pd.DataFrame,
    tests: pd.DataFrame | None = None,
    model: Any = "linear",
    add: Iterable[str | Effect] | str | Effect = (),
    force: bool = False,
    seed: int = 0,
    progress: Progress | None = None,
) -> FrictionModel:
    """Return `model` with effects added, base and effects fitted together.

    The result is fitted to the tests whose `role` is ``train`` (to all where no role is recorded) and
    confirmed against the ordinary fit of `model` on whole tests that the fit did not see: those of another
    role, else by cross-validation. The errors before and after are appended to ``error_history_``.

    Tests that lie far off what all others say are left out as by `diagnose`, and named in ``judged_by``.

    A fault of the data (`sensor_drift`, ...) corrects the measurements and is no part of the model's predictions or
    files. For the errors it is taken off the measured mu, so that the model is judged by what the friction was.

    Parameters
    ----------
    data : pandas.DataFrame
        Points with `mu`.
    tests : pandas.DataFrame, optional
        Metadata; column `role` marks held-out tests.
    model : str or FrictionModel
        Family name or model, also one that holds effects already.
    add : iterable of str or Effect
        What to add; nothing returns `model`, refitted.
    force : bool
        Keep an addition that makes held-out tests worse.
    seed : int
        Of the folds.
    progress : callable, optional
        Called with the number of fits that are done, of all, and what is fitted.

    Returns
    -------
    FrictionModel
        Fitted; with effects a `ComposedFriction`.

    Raises
    ------
    InputError
        A model that cannot be refitted, an unknown effect, or an addition that makes held-out tests worse.
    """
    base = make_model(model) if isinstance(model, str) else model
    if not isinstance(base, FrictionModel):
        raise InputError(
            f"refine: {type(base).__name__} cannot be refitted; allowed: a family name or a friction model of this project"
        )
    if base.family == "constant" and getattr(base, "mu", None) is not None:
        base = type(base)()  # a given constant has nothing to refit; its level is fitted with the effect
    added = [make_effect(e) for e in ([add] if isinstance(add, (str, Effect)) else list(add))]
    inner = base.base if isinstance(base, ComposedFriction) else base
    present = list(base.effects) if isinstance(base, ComposedFriction) else []
    held_effects = [make_effect(e) for e in [*present, *added]]
    campaign = prepare(data, tests)
    campaign, odd = _without_odd(campaign, base, seed) if added else (campaign, ())
    metadata = [m for e in held_effects for m in e.metadata]
    loads, mu = with_all_metadata(campaign.loads, metadata), campaign.mu
    read = with_all_metadata(campaign.as_read, metadata)
    held = _held_out(loads)
    if not added:
        rows = ~held if held is not None else np.ones(len(mu), dtype=bool)
        plain = clone(base).fit(read.take(rows), mu[rows], names_of(loads, rows))
        return plain.record_data(data.attrs).record_tests(data)
    refined = ComposedFriction(clone(inner), [*present, *added])
    history = list(getattr(base, "error_history_", []))
    fold = folds_of(campaign, seed)[campaign.point_test]
    folds = [held] if held is not None else [fold == k for k in range(fold.max() + 1) if fold.max()]
    before, after = np.full(len(mu), np.nan), np.full(len(mu), np.nan)
    fitted: Any = None
    told = progress or (lambda done, total, what: None)
    for k, unseen in enumerate(folds):
        told(2 * k, 2 * len(folds), "the model as it was")
        _, before[unseen] = predicted_unseen(base, loads, mu, unseen)
        told(2 * k + 1, 2 * len(folds), "the model with what is added")
        fitted, after[unseen] = predicted_unseen(refined, loads, mu, unseen)
    if held is None:
        fitted = clone(refined).fit(loads, mu, names_of(loads, np.ones(len(mu), dtype=bool)))
    by = (
        f"{len(np.unique(campaign.point_test[held]))} held-out tests"
        if held is not None
        else f"{len(folds)}-fold cross-validation by whole tests"
    )
    if odd:
        by += f", without {first_names(odd)}, far off what all others say"
    if folds:
        seen = np.isfinite(after)
        groups = names_of(loads, seen)
        error_before, error_after = (before - mu)[seen], (after - mu)[seen]
        _, unseen_test = np.unique(campaign.point_test[seen], return_inverse=True)
        intervals, clear = before_and_after(error_before, error_after, unseen_test, seed)
        _, rose = before_and_after(error_after, error_before, unseen_test, seed)
        entry: Addition = {
            "added": [e.name for e in added],
            "judged_by": by,
            "corrects_data": [e.name for e in added if e.kind == "fault"],
            "before": error_measures(mu[seen], before[seen], groups),
            "after": error_measures(mu[seen], after[seen], groups),
            "intervals": intervals,
            "clear": clear,
            "rose": rose,
        }
        if not force and _worse(error_before, error_after, campaign.point_test[seen]):
            raise InputError(
                f"refine: adding {', '.join(e.name for e in added)} raises the error on {by} from "
                f"{entry['before']['rmse']:.5f} to {entry['after']['rmse']:.5f}; allowed: additions that do not, or --force (in Python force=True)"
            )
        history.append(entry)
        fitted.record_errors("held_out" if held is not None else "cross_validated", entry["after"])
    fitted.error_history_ = history
    # what was trained on is what was read, noise of the sensors included
    fitted.domain_ = fitted.base_.domain_ = Domain.of(read if held is None else read.take(~held))
    return fitted.record_data(data.attrs).record_tests(data)


def _without_odd(
    campaign: BinnedTests, base: FrictionModel, seed: int
) -> tuple[BinnedTests, tuple[str, ...]]:
    """Return the tests that `diagnose` judges, and the names of those that lie far off what all others say."""
    try:
        found = without_odd(tests_beside(campaign, base, seed), base, seed)
    except InputError:  # too little to look for effects can be enough to fit one that is given
        return campaign, ()
    return found.measured, found.odd


def history_text(history: Sequence[Mapping[str, Any]]) -> str:
    """Return the rounds of additions with the errors before and after, on tests that the fit did not see."""
    if not history:
        return "No round was judged: too few tests to leave some out."
    lines = [
        "Rounds of additions (RMSE and MAE of mu over the points of tests not seen in the fit; the error budget of diagnose averages points first)"
    ]
    for k, entry in enumerate(history, 1):
        before, after = entry["before"], entry["after"]
        lines.append(
            f"  {k}  + {' + '.join(entry['added']):<24} RMSE {before['rmse']:.5f} -> {after['rmse']:.5f}   "
            f"MAE {before['mae']:.5f} -> {after['mae']:.5f}   ({entry['judged_by']})"
            + ("" if after["rmse"] < BETTER * before["rmse"] else "  NO BETTER")
        )
        lines += _sure(entry)
        faults = entry.get("corrects_data", [])
        if faults:
            lines.append(
                f"     {' and '.join(faults)}: correct{'s' if len(faults) == 1 else ''} the data the model is fitted to and judged by; "
                "not in its predictions, not in exported files"
            )
    return "\n".join(lines) + "\n"


def fault_note(model: FrictionModel) -> str:
    """Return that measurements hold the faults that a model leaves out; empty where it corrects the data for none."""
    faults = [e.name for e in getattr(model, "effects_", []) if e.kind == "fault"]
    if not faults:
        return ""
    return f"The measurements still hold {' and '.join(faults)} here, which the model leaves out; only the rounds are judged without."


def _sure(entry: Mapping[str, Any]) -> list[str]:
    """Return a line with the 95 % intervals of the RMSE of a round, and whether it changed by more than chance; none where they are not known."""
    intervals = entry.get("intervals", {})
    found = [intervals.get(when, {}).get("rmse") for when in ("before", "after", "fall")]
    if any(f is None for f in found):
        return []
    before, after, fall = (f"{low:.5f} to {high:.5f}" for low, high in found)
    chance = "more than chance" if entry.get("clear") else "which may be chance"
    changed = rise_text(entry) or f"lower by {fall}: {chance}"
    return [f"     95 % of resampled tests: RMSE {before} -> {after}, {changed}"]


def _held_out(loads: TriboLoads) -> np.ndarray | None:
    """Return which points belong to tests of another role than ``train``, or None without such tests."""
    roles = loads.context_column("role")
    if roles is None:
        return None
    held = np.asarray(roles).astype(str) != "train"
    return held if held.any() and not held.all() else None


def _worse(before: FloatArray, after: FloatArray, group: np.ndarray) -> bool:
    """Return whether the error rose, by more than chance over tests allows."""
    if np.sqrt(np.mean(after**2)) <= WORSE * np.sqrt(np.mean(before**2)):
        return False
    _, test = np.unique(group, return_inverse=True)
    difference = np.bincount(test, after**2 - before**2)
    spread = float(np.std(difference, ddof=1)) * np.sqrt(len(difference)) if len(difference) > 1 else 0.0
    return bool(difference.sum() > spread)
