"""What the model under test may still adjust while effects are scanned: its columns, and a fixed part."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np

from ..common import InputError
from ..loads import LOAD_NAMES, FloatArray
from ..models.predicted import ALLOWED, predict_points
from .binning import Campaign

FOLDS = 5


@dataclass
class BaseLaw:
    """The base of a diagnosis.

    Attributes
    ----------
    name : str
        Family, or file of a fixed law, for the report.
    columns : ndarray, shape (n, p)
        Terms on all points whose coefficients are fitted together with every candidate effect.
    offset : ndarray, shape (n,)
        Part of mu that is not refitted: predictions of a fixed or of a flexible base.
    fixed : bool
        Whether the model is taken as it is (an FMU, a constant of given value).
    effects : tuple of str
        Effects that the model holds already.
    model : object
        The model given, for the domain and for a later refit.
    """

    name: str
    columns: FloatArray
    offset: FloatArray
    fixed: bool = False
    effects: tuple[str, ...] = ()
    model: Any = field(default=None, repr=False)


def scaled_loads(campaign: Campaign) -> FloatArray:
    """Return the loads that vary, centred and scaled to unit spread, shape (n, k)."""
    array = campaign.loads.as_array()
    keep = [j for j, name in enumerate(LOAD_NAMES) if campaign.varies(name)]
    chosen = array[:, keep]
    if not keep:
        return chosen
    return (chosen - chosen.mean(axis=0)) / chosen.std(axis=0)


def polynomial_columns(campaign: Campaign, degree: int) -> FloatArray:
    """Return all products of the scaled loads up to `degree`, constant first."""
    z = scaled_loads(campaign)
    columns = [np.ones(len(z))]
    for d in range(1, degree + 1):
        columns += [
            np.prod(z[:, list(c)], axis=1) for c in combinations_with_replacement(range(z.shape[1]), d)
        ]
    return np.column_stack(columns)


def base_law(model: Any, campaign: Campaign, seed: int = 0) -> BaseLaw:
    """Return what a model leaves to fit.

    Parameters
    ----------
    model : str, FrictionModel or object with ``predict(array[n, 5])``
        Family name; model, fitted or not; anything else that predicts is a fixed base. Where it has ``predict_frame``
        (a friction FMU, an ONNX model), that is asked, so that memory and system variables act.
    campaign : Campaign
    seed : int
        Folds of a flexible base.

    Raises
    ------
    InputError
        An unknown family, or an object that cannot predict.
    """
    from ..families.registry import make_model
    from ..models.base import FrictionModel

    if isinstance(model, str):
        model = make_model(model)
    zero = np.zeros(len(campaign.mu))
    if isinstance(model, FrictionModel):
        family = model.family
        if family == "composed":
            return _composed_law(model, campaign, seed)
        if family == "constant" and getattr(model, "mu", None) is None:
            return BaseLaw(family, polynomial_columns(campaign, 0), zero, model=model)
        if family == "linear":
            return BaseLaw(family, polynomial_columns(campaign, 1), zero, model=model)
        if family == "polynomial":
            return BaseLaw(family, polynomial_columns(campaign, int(model.degree)), zero, model=model)  # type: ignore[attr-defined]
        if family == "power_law":
            return _power_law(model, campaign)
        if family != "constant":
            offset = out_of_fold(model, campaign, seed)
            columns = np.column_stack([polynomial_columns(campaign, 1), offset])
            return BaseLaw(family, columns, zero, model=model)
    if isinstance(model, type) or not hasattr(model, "predict"):
        raise InputError(f"model {model!r:.80}: allowed is a family name, a model, or {ALLOWED}")
    offset = predict_points(f"model {model!r:.80}", model, campaign.loads, campaign.loads.tests_table())
    file = getattr(model, "path", None)  # an FMU, an ONNX file
    name = file.name if isinstance(file, Path) else str(getattr(model, "family", type(model).__name__))
    return BaseLaw(name, polynomial_columns(campaign, 0), offset, fixed=True, model=model)


def _power_law(model: Any, campaign: Campaign) -> BaseLaw:
    """Linearise the multiplicative law around its fit: its columns are d mu / d parameter."""
    from sklearn.base import clone

    fitted = clone(model).fit(campaign.loads, campaign.mu)
    mu = fitted.predict(campaign.loads)
    loads = campaign.loads
    v0, s0, d0 = fitted.offsets()
    logs = [
        np.log(loads.v_rel + v0),
        loads.T,
        np.log(loads.sigma_n + s0),
        np.log(loads.sd + d0),
        np.log(loads.psi),
    ]
    columns = np.column_stack([mu, *(mu * (f - f.mean()) / max(float(f.std()), 1e-12) for f in logs)])
    return BaseLaw("power_law", columns, mu, model=model)


def _composed_law(model: Any, campaign: Campaign, seed: int) -> BaseLaw:
    """Refit the composed model's amplitudes: its base's columns and its effects at their fitted shapes."""
    from sklearn.base import clone

    from .candidates import evaluate_points

    fitted = model if model.is_fitted else clone(model).fit(campaign.loads, campaign.mu)
    inner = base_law(fitted.base, campaign, seed)
    mu = fitted.predict(campaign.loads)
    terms = []
    for effect, shape in zip(fitted.effects_, fitted.shapes_, strict=True):
        terms += [np.broadcast_to(c, (len(mu), 1)) for c in evaluate_points(effect, campaign, mu, shape)]
    columns = np.column_stack([inner.columns, *terms])
    names = tuple(e.name for e in fitted.effects_)
    return BaseLaw("+".join([inner.name, *names]), columns, inner.offset, effects=names, model=model)


def out_of_fold(model: Any, campaign: Campaign, seed: int) -> FloatArray:
    """Return predictions for each test by copies of the model that never saw that test.

    A single test is predicted by a model of the same test: there is nothing else to learn from.
    """
    from sklearn.base import clone

    tests = len(campaign.tests)
    point_test = campaign.point_test
    names = np.array(campaign.tests)[point_test]
    if tests < 2:
        return np.asarray(clone(model).fit(campaign.loads, campaign.mu).predict(campaign.loads))
    fold_of_test = np.random.default_rng(seed).permutation(tests) % min(FOLDS, tests)
    predicted = np.empty(len(campaign.mu))
    for fold in range(min(FOLDS, tests)):
        held = fold_of_test[point_test] == fold
        copy = clone(model).fit(campaign.loads.take(~held), campaign.mu[~held], groups=names[~held])
        predicted[held] = copy.predict(campaign.loads.take(held))
    return predicted
