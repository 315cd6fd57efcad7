"""One model of every family and every effect that is exported, with typical parameters and without long fits."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from friction_models.effects import CATALOGUE, make_effect
from friction_models.families.composed import ComposedFriction
from friction_models.families.registry import FAMILIES, make_model
from friction_models.models.base import FrictionModel
from friction_models.models.onnx_export import build_onnx
from friction_models.models.variables import SystemVariable
from tests.fmus.graphs import campaign

#: Faults of the data and of the twin take part in fits only; they never stand in a file.
EXPORTED = [name for name, effect in CATALOGUE.items() if effect.kind != "fault"]
SMALL: dict[str, dict[str, Any]] = {
    "ffnn": {"hidden": (24, 16), "members": 2, "epochs": 2},
    "gradient_boosting": {"trees": 40},
}
NAMES = [
    *FAMILIES,
    *(f"linear + {e}" for e in EXPORTED),
    "ffnn + work_exhaustion + tool_roughness",
    "polynomial + stribeck + flash_temperature + rate_state + work_exhaustion",
]


@cache
def model_of(name: str) -> FrictionModel:
    """Return a model such as ``linear + stribeck``: the base fitted, the effects at their start values."""
    family, *effects = name.split(" + ")
    if effects:
        base = model_of(family)
        model = ComposedFriction(make_model(family, **SMALL.get(family, {})), effects)
        model.domain_, model.base_ = base.domain, base
        model.effects_ = [make_effect(e) for e in effects]
        model.shapes_ = [e.start_shape() for e in model.effects_]
        model.amplitudes_ = [{a.name: a.start for a in e.amplitudes} for e in model.effects_]
        model.levels_, model.noise_floor_ = {}, {}
        needed = {m: u for e in model.effects_ for m, u in zip(e.metadata, e.metadata_units, strict=True)}
        model.system_ = [SystemVariable(n, u, 0.4, 0.0, 2.0) for n, u in needed.items()]
        return model
    points, _ = campaign()
    # One load more than a straight line, so that no coefficient vanishes.
    points["mu"] += 0.01 * np.log(points["psi"]) + 2e-5 * points["v_rel"] - 1e-5 * points["sigma_n"]
    return make_model(family, **SMALL.get(family, {})).fit_frame(points)


@cache
def content_of(name: str) -> bytes:
    """Return the ONNX file of a model."""
    return build_onnx(model_of(name)).SerializeToString(deterministic=True)
