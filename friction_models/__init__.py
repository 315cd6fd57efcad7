"""Friction models of the five tribological loads; knows nothing of FMI.

Attributes are imported on first use: `friction_models.loads` alone costs no scikit-learn or torch.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import discovery as discovery
    from . import effects as effects
    from . import training as training
    from .common import InputError as InputError
    from .families.composed import ComposedFriction as ComposedFriction
    from .families.constant import ConstantFriction as ConstantFriction
    from .families.ffnn import FeedForwardFriction as FeedForwardFriction
    from .families.gradient_boosting import GradientBoostingFriction as GradientBoostingFriction
    from .families.linear import LinearFriction as LinearFriction
    from .families.loading import load_model as load_model
    from .families.polynomial import PolynomialFriction as PolynomialFriction
    from .families.power_law import PowerLawFriction as PowerLawFriction
    from .families.registry import FAMILIES as FAMILIES
    from .families.registry import make_model as make_model
    from .loads import DataSet as DataSet
    from .loads import TriboLoads as TriboLoads
    from .models.base import FrictionModel as FrictionModel
    from .models.domain import Domain as Domain
    from .models.onnx_model import OnnxModel as OnnxModel
    from .training import Evaluation as Evaluation
    from .training import evaluate as evaluate

_EXPORTS = {
    "FAMILIES": "families.registry",
    "ComposedFriction": "families.composed",
    "ConstantFriction": "families.constant",
    "DataSet": "loads",
    "Domain": "models.domain",
    "Evaluation": "training.evaluation",
    "FeedForwardFriction": "families.ffnn",
    "FrictionModel": "families",
    "GradientBoostingFriction": "families.gradient_boosting",
    "InputError": "common",
    "LinearFriction": "families.linear",
    "OnnxModel": "models.onnx_model",
    "PolynomialFriction": "families.polynomial",
    "PowerLawFriction": "families.power_law",
    "TriboLoads": "loads",
    "evaluate": "training.evaluation",
    "load_model": "families.loading",
    "make_model": "families.registry",
}
_SUBPACKAGES = ("discovery", "effects", "training")

__all__ = sorted([*_EXPORTS, *_SUBPACKAGES])


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    if name in _SUBPACKAGES:
        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
