"""`refine`: add effects to a model, fit base and effects together, confirm on whole tests that were held out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from sklearn.base import clone

from ..common import InputError
from ..common.processes.one_blas_thread import one_blas_thread
from ..common.processes.pool import Progress
from ..common.wording import first_names
from ..effects import make_effect
from ..effects.base import Effect
from ..estimation.campaign.binned_tests import BinnedTests
from ..estimation.campaign.binning import part_of, prepare
from ..estimation.campaign.factors import check_factors
from ..estimation.campaign.metadata import with_all_metadata
from ..estimation.fit.joint_fit import surrogate
from ..estimation.fit.parameters import fit_terms
from ..estimation.search.unseen_loads import unvaried
from ..expressions.parameters import check_seed
from ..families.composed import ComposedFriction
from ..families.registry import make_model
from ..loads import FloatArray, TriboLoads
from ..loads.dataset import TRAINING, roles_of
from ..loads.splits import Mask
from ..models.base import FrictionModel
from ..models.domain import Domain
from .answer.fit_warnings import about_the_fit
from .judge.unseen_tests import folds_of, names_of
from .judged_addition import judged_addition, models_to_judge, unseen_predictions
from .judged_tests import tests_beside, without_odd

#: An addition is refused when the held-out error rises by more than this, and clearly so (paired over tests).
WORSE = 1.01


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

    Base and effects together are fitted with other weights than `model` alone, which can lower the error without the effects.
    So `model` is judged with these weights, too, and an addition that is no better than that is marked so.
    Of several effects each is also left out, the others fitted anew, which shows whether it is needed beside them.

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
        A model that cannot be refitted, an unknown effect, a factor of a column with one level or with another text in nearly
        every test, or an addition that makes held-out tests worse.
    """
    check_seed("refine", seed)
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
    _check_driven(campaign, added)
    campaign, odd = _without_odd(campaign, base, seed) if added else (campaign, ())
    metadata = [m for e in held_effects for m in e.metadata]
    loads, mu = with_all_metadata(campaign.loads, metadata), campaign.mu
    read = with_all_metadata(campaign.as_read, metadata)
    held = _held_out(loads)
    rows = np.ones(len(mu), dtype=bool) if held is None else ~held
    if not added:
        plain = clone(base).fit(read.take(rows), mu[rows], names_of(loads, rows))
        return plain.record_data(data.attrs).record_tests(data)
    check_factors(campaign, added, _fitted_tests(campaign, held))
    refined = ComposedFriction(clone(inner), [*present, *added])
    history = list(getattr(base, "error_history_", []))
    fold = folds_of(campaign, seed)[campaign.point_test]
    folds = [held] if held is not None else [fold == k for k in range(fold.max() + 1) if fold.max()]
    models = models_to_judge(base, refined, added, loads)
    fitted = clone(refined).fit(loads.take(rows), mu[rows], names_of(loads, rows))
    predicted = unseen_predictions(models, loads, mu, folds, fitted, progress)
    by = (
        f"{len(np.unique(campaign.point_test[held]))} held-out tests"
        if held is not None
        else f"{len(folds)}-fold cross-validation by whole tests"
    )
    if odd:
        by += f", without {first_names(odd)}, which diagnose leaves out, too"
    if folds:
        entry = judged_addition(predicted, mu, campaign.point_test, loads.test_id, added, by, seed)
        if not force and _worse(predicted, mu, campaign.point_test):
            raise InputError(
                f"refine: adding {', '.join(e.name for e in added)} raises the error on {by} from "
                f"{entry['before']['rmse']:.5f} to {entry['after']['rmse']:.5f}; allowed: additions that do not, or --force (in Python force=True)"
            )
        learned = campaign if held is None else part_of(campaign, rows)
        terms = fit_terms(learned, surrogate(clone(inner), learned), held_effects)
        entry["warnings"] = about_the_fit(learned, terms)
        if odd:
            entry["left_out"] = list(odd)
        history.append(entry)
        fitted.record_errors("held_out" if held is not None else "cross_validated", entry["after"])
    fitted.error_history_ = history
    # what was trained on is what was read, noise of the sensors included
    fitted.domain_ = fitted.base_.domain_ = Domain.of(read.take(rows))
    return fitted.record_data(data.attrs).record_tests(data)


def _check_driven(campaign: BinnedTests, added: Sequence[Effect]) -> None:
    """Refuse an effect of loads of which none varies: any size of it fits.

    Raises InputError.
    """
    for effect in added:
        loads = [n for n in effect.driver if n not in campaign.absent]
        if loads and unvaried(effect, campaign):
            raise InputError(
                f"refine: {effect.name} needs {' or '.join(loads)} to vary, which the tests do not change; allowed: effects of "
                f"{', '.join(campaign.varied) or 'loads that vary'}"
            )


def _without_odd(
    campaign: BinnedTests, base: FrictionModel, seed: int
) -> tuple[BinnedTests, tuple[str, ...]]:
    """Return the tests that `diagnose` judges, and the names of those that lie far off what all others say."""
    try:
        found = without_odd(tests_beside(campaign, base, seed), base, seed)
    except InputError:  # too little to look for effects can be enough to fit one that is given
        return campaign, ()
    return found.measured, found.odd


def _held_out(loads: TriboLoads) -> np.ndarray | None:
    """Return which points belong to tests of another role than ``train``, or None without such tests; a blank is none."""
    roles = loads.context_column("role")
    if roles is None:
        return None
    held = (roles_of(pd.Series(roles)) != TRAINING).to_numpy()
    return held if held.any() and not held.all() else None


def _fitted_tests(campaign: BinnedTests, held: Mask | None) -> Mask:
    """Return which tests are fitted, shape (tests,)."""
    if held is None:
        return np.ones(len(campaign.tests), dtype=bool)
    return ~np.asarray(held)[campaign.point_starts]


def _worse(predicted: Mapping[str, FloatArray], mu: FloatArray, point_test: np.ndarray) -> bool:
    """Return whether the error rose, by more than chance over tests allows."""
    seen = np.isfinite(predicted["after"])
    before, after = ((predicted[when] - mu)[seen] for when in ("before", "after"))
    group = point_test[seen]
    if np.sqrt(np.mean(after**2)) <= WORSE * np.sqrt(np.mean(before**2)):
        return False
    _, test = np.unique(group, return_inverse=True)
    difference = np.bincount(test, after**2 - before**2)
    spread = float(np.std(difference, ddof=1)) * np.sqrt(len(difference)) if len(difference) > 1 else 0.0
    return bool(difference.sum() > spread)
