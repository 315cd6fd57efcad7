"""What an addition to a model does on tests that the fits did not see: one round of ``error_history_``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NotRequired, TypedDict

import numpy as np
import numpy.typing as npt
from sklearn.base import clone

from ..common.processes.pool import Progress
from ..effects.base import Effect
from ..families.composed import ComposedFriction
from ..loads import FloatArray, TriboLoads
from ..loads.splits import Mask
from ..models.base import FrictionModel
from ..models.measures import error_measures
from .judge.unseen_tests import near_measured, predicted_measurements, predicted_unseen
from .resampling import before_and_after

#: What is fitted, by the name of its errors in a round.
FITTED = {
    "before": "the model as it was",
    "refitted": "the model as it was, with the weights of the joint fit",
    "after": "the model with what is added",
}
#: Before the name of an effect that is left out of those added.
WITHOUT = "without "


class Addition(TypedDict):
    """One entry of ``error_history_``: what was added, and the errors before and after on tests that the fit did not see.

    Examples
    --------
    Six tests in which friction falls with temperature, as a constant with the effect describes and a constant does not:

    >>> import pandas as pd
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
    #: Errors of the model before, refitted as the model after is, where that is another fit than ``before``; not in older files.
    refitted: NotRequired[dict[str, float]]
    #: Of several effects added, by the name of each: the errors ``after`` without it, the others fitted anew, and whether it is
    #: ``needed``, that is whether the RMSE without it is higher by more than chance; not in older files.
    without: NotRequired[dict[str, dict[str, Any]]]
    #: What of the fitted parameters is not known; not in older files.
    warnings: NotRequired[list[str]]
    #: Tests that lie far off what all others say, without which all was fitted and judged.
    left_out: NotRequired[list[str]]


def models_to_judge(
    base: FrictionModel, refined: ComposedFriction, added: Sequence[Effect], loads: TriboLoads
) -> dict[str, FrictionModel]:
    """Return the unfitted models of a round by what they are: ``before``, ``refitted``, ``after``, and of several effects ``without NAME``.

    A joint fit weighs by the noise floor, or takes ordinary least squares where these predict tests left out better. ``before`` is
    the ordinary fit and ``refitted`` the joint fit without an effect, so both weights are tried without what is added. A model
    with effects is fitted jointly as it is: there ``before`` is both. So it is where a law is not linear, which a joint fit fits to
    what the effects leave with no weights but those of uncertain loads.
    """
    models: dict[str, FrictionModel] = {"before": base}
    if not isinstance(base, ComposedFriction) and (base.form == "linear" or loads.stated_uncertainty()):
        models["refitted"] = ComposedFriction(clone(base), [])
    models["after"] = refined
    for effect in added if len(added) > 1 else ():
        others = [e for e in refined.effects if e is not effect]
        models[WITHOUT + effect.name] = ComposedFriction(clone(refined.base), others)
    return models


def unseen_predictions(
    models: Mapping[str, FrictionModel],
    loads: TriboLoads,
    mu: FloatArray,
    folds: Sequence[Mask],
    final: FrictionModel,
    progress: Progress | None = None,
) -> dict[str, FloatArray]:
    """Return what each model predicts of the tests that its fits did not see, shape (n,).

    A single fold is held out: there ``after`` is `final`, the model that the user gets, and no prediction is limited. Points that
    are in no fold are NaN. `progress` is told of every fit.
    """
    held_out = len(folds) == 1
    told = progress or (lambda done, total, what: None)
    predicted = {name: np.full(len(mu), np.nan) for name in models}
    for k, unseen in enumerate(folds):
        for j, (name, model) in enumerate(models.items()):
            told(k * len(models) + j, len(folds) * len(models), FITTED.get(name, name))
            if held_out and name == "after":
                found = predicted_measurements(final, loads.take(unseen))
            else:
                found = predicted_unseen(model, loads, mu, unseen)
            predicted[name][unseen] = found if held_out else near_measured(mu[~unseen], found)
    return predicted


def judged_addition(
    predicted: Mapping[str, FloatArray],
    mu: FloatArray,
    point_test: npt.NDArray[np.intp],
    names: npt.NDArray[Any] | None,
    added: Sequence[Effect],
    judged_by: str,
    seed: int,
) -> Addition:
    """Return the round that `unseen_predictions` show; `point_test` numbers the test of each point, `names` names it."""
    seen = np.isfinite(predicted["after"])
    groups = None if names is None else names[seen]
    error = {name: (values - mu)[seen] for name, values in predicted.items()}
    measures = {name: error_measures(mu[seen], values[seen], groups) for name, values in predicted.items()}
    _, unseen_test = np.unique(point_test[seen], return_inverse=True)
    change = before_and_after(error["before"], error["after"], unseen_test, seed)
    entry: Addition = {
        "added": [e.name for e in added],
        "judged_by": judged_by,
        "corrects_data": [e.name for e in added if e.kind == "fault"],
        "before": measures["before"],
        "after": measures["after"],
        "intervals": change.intervals,
        "clear": change.fell,
        "rose": change.rose,
    }
    if "refitted" in measures:
        entry["refitted"] = measures["refitted"]
    left_out = {e.name: WITHOUT + e.name for e in added if WITHOUT + e.name in measures}
    if left_out:
        entry["without"] = {
            name: {
                **measures[key],
                "needed": before_and_after(error[key], error["after"], unseen_test, seed).fell,
            }
            for name, key in left_out.items()
        }
    return entry
