"""The model under test while effects are scanned: what a fit may still change in it, and a fixed part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...common import InputError
from ...loads import FloatArray
from ...models.base import FrictionModel
from ...models.measures import ALLOWED, predict_points
from ...models.tangent import MeasuredPoints
from ..campaign.binned_tests import BinnedTests
from .candidates import evaluate_points


@dataclass
class BaseLaw:
    """The base of a diagnosis."""

    name: str  #: Family, or file of a fixed law, for the report.
    #: Terms on all points whose coefficients are fitted together with every candidate effect, shape (n, p).
    columns: FloatArray
    offset: FloatArray  #: Part of mu that is not refitted: predictions of a fixed base. Shape (n,).
    fixed: bool = False  #: Whether the model is taken as it is (an FMU, a constant of given value).
    effects: tuple[str, ...] = ()  #: Effects that the model holds already.
    model: Any = field(default=None, repr=False)  #: The model given, for the domain and for a later refit.
    #: What other values of its constants would do, which no fit changes, by parameter; each of shape (n,).
    constants: Mapping[str, FloatArray] = field(default_factory=dict)


def base_law(model: Any, campaign: BinnedTests, seed: int = 0) -> BaseLaw:
    """Return what a model leaves to fit.

    A `FrictionModel`, fitted or not, says itself what may change; anything else that predicts, by ``predict(array[n, 5])``, is
    a fixed base. Where it has ``predict_frame`` (a friction FMU, an ONNX model), that is asked, so that memory and system
    variables act. `seed` is that of the folds of a flexible base.
    Raises InputError: an object that cannot predict.
    """
    if isinstance(model, FrictionModel):
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
        return BaseLaw(name, found.columns, found.offset, found.fixed, found.effects, model, found.constants)
    if isinstance(model, type) or not hasattr(model, "predict"):
        raise InputError(f"model {model!r:.80}: allowed is a family name, a model, or {ALLOWED}")
    offset = predict_points(f"model {model!r:.80}", model, campaign.loads, campaign.loads.tests_table())
    file = getattr(model, "path", None)  # an FMU, an ONNX file
    name = file.name if isinstance(file, Path) else str(getattr(model, "family", type(model).__name__))
    return BaseLaw(name, np.ones((len(offset), 1)), offset, fixed=True, model=model)
