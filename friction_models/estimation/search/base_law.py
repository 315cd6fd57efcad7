"""The model under test while effects are scanned: what a fit may still change in it, and a fixed part."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...common import InputError
from ...common.errors import shown
from ...loads import FloatArray
from ...models.base import FrictionModel
from ...models.measures import ALLOWED, predict_points
from ...models.tangent import Beside, MeasuredPoints
from ..campaign.binned_tests import BinnedTests
from .candidates import evaluate_points
from .fixed_level import is_scaled


@dataclass
class BaseLaw:
    """The base of a diagnosis."""

    name: str  #: Family, or file of a fixed law, for the report.
    #: Terms on all points whose coefficients are fitted together with every candidate effect, shape (n, p).
    columns: FloatArray
    offset: FloatArray  #: Part of mu that is not refitted: predictions of a fixed base. Shape (n,).
    fixed: bool = False  #: Whether the model is taken as it is (an FMU, a constant of given value).
    scaled: bool = False  #: Whether such a model may be scaled: its last column is what it predicts.
    effects: tuple[str, ...] = ()  #: Effects that the model holds already.
    model: Any = field(default=None, repr=False)  #: The model given, for the domain and for a later refit.
    beside: tuple[Beside, ...] = ()  #: What the model could do, though no fit of it does.


def base_law(model: Any, campaign: BinnedTests, seed: int = 0) -> BaseLaw:
    """Return what a model leaves to fit.

    A `FrictionModel`, fitted or not, says itself what may change; anything else that predicts, by ``predict(array[n, 5])``, is
    a fixed base. Where it has ``predict_frame`` (a friction FMU, an ONNX model), that is asked, so that memory and system
    variables act. `seed` is that of the folds of a flexible base.
    Raises InputError: an object that cannot predict; tests without metadata that a model was fitted with.
    """
    if isinstance(model, FrictionModel):
        _check_metadata(model, campaign)
        points = MeasuredPoints(
            campaign.loads,
            campaign.mu,
            campaign.tests,
            campaign.point_test,
            lambda effect, mu, shape: evaluate_points(effect, campaign, mu, shape),
            seed,
        )
        found = model.tangent(points)
        name = model.name.replace(" + ", "+")
        law = BaseLaw(
            name,
            found.columns,
            found.offset,
            fixed=found.fixed,
            effects=found.effects,
            model=model,
            beside=found.beside,
        )
        return _with_level(law, campaign)
    if isinstance(model, type) or not hasattr(model, "predict"):
        raise InputError(f"model {model!r:.80}: allowed is a family name, a model, or {ALLOWED}")
    offset = predict_points(f"model {model!r:.80}", model, campaign.loads, campaign.loads.tests_table())
    file = getattr(model, "path", None)  # an FMU, an ONNX file
    name = file.name if isinstance(file, Path) else str(getattr(model, "family", type(model).__name__))
    return _with_level(BaseLaw(name, np.ones((len(offset), 1)), offset, fixed=True, model=model), campaign)


def _check_metadata(model: FrictionModel, campaign: BinnedTests) -> None:
    """Refuse tests without metadata of a fitted model: it is refitted, which takes what each test had."""
    lacking = (
        [v.name for v in model.system_variables if v.name not in campaign.system] if model.is_fitted else []
    )
    if lacking:
        raise InputError(
            f"the {model.name} model needs the column {shown(lacking[0], 60)!r} of the table of tests, as it is fitted anew; allowed: "
            "a table of tests with it"
        )


def _with_level(law: BaseLaw, campaign: BinnedTests) -> BaseLaw:
    """Return a law that, where it is taken as it is and is off by a factor, may be scaled and not only shifted."""
    if law.fixed and is_scaled(*(campaign.of_tests(campaign.average(v)) for v in (law.offset, campaign.mu))):
        law.columns, law.scaled = np.column_stack([law.columns, law.offset]), True
    return law
