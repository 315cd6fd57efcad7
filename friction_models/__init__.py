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
    from .base import FrictionModel as FrictionModel
    from .composed import ComposedFriction as ComposedFriction
    from .constant import ConstantFriction as ConstantFriction
    from .domain import Domain as Domain
    from .ffnn import FeedForwardFriction as FeedForwardFriction
    from .gradient_boosting import GradientBoostingFriction as GradientBoostingFriction
    from .linear import LinearFriction as LinearFriction
    from .loads import DataSet as DataSet
    from .loads import InputError as InputError
    from .loads import TriboLoads as TriboLoads
    from .onnx_export import OnnxModel as OnnxModel
    from .polynomial import PolynomialFriction as PolynomialFriction
    from .power_law import PowerLawFriction as PowerLawFriction
    from .registry import FAMILIES as FAMILIES
    from .registry import make_model as make_model
    from .saving import load_model as load_model
    from .training import Evaluation as Evaluation
    from .training import evaluate as evaluate

_EXPORTS = {
    "FAMILIES": "registry",
    "ComposedFriction": "composed",
    "ConstantFriction": "constant",
    "DataSet": "loads",
    "Domain": "domain",
    "Evaluation": "training.evaluation",
    "FeedForwardFriction": "ffnn",
    "FrictionModel": "base",
    "GradientBoostingFriction": "gradient_boosting",
    "InputError": "loads",
    "LinearFriction": "linear",
    "OnnxModel": "onnx_export",
    "PolynomialFriction": "polynomial",
    "PowerLawFriction": "power_law",
    "TriboLoads": "loads",
    "evaluate": "training.evaluation",
    "load_model": "saving",
    "make_model": "registry",
}
_SUBPACKAGES = ("discovery", "effects", "training")

__all__ = sorted([*_EXPORTS, *_SUBPACKAGES])


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    if name in _SUBPACKAGES:
        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
