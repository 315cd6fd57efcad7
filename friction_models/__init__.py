"""Friction models of the five tribological loads; knows nothing of FMI.

Attributes are imported on first use: `friction_models.loads` alone costs no scikit-learn or torch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .common.imports.lazy_names import lazily

if TYPE_CHECKING:
    from . import discovery as discovery
    from . import effects as effects
    from . import training as training
    from .cards import Card as Card
    from .cards import load_card as load_card
    from .cards import load_cards as load_cards
    from .cards import load_model as load_model
    from .common import InputError as InputError
    from .families import ComposedFriction as ComposedFriction
    from .families import FrictionModel as FrictionModel
    from .families.constant import ConstantFriction as ConstantFriction
    from .families.ffnn import FeedForwardFriction as FeedForwardFriction
    from .families.gradient_boosting import GradientBoostingFriction as GradientBoostingFriction
    from .families.linear import LinearFriction as LinearFriction
    from .families.polynomial import PolynomialFriction as PolynomialFriction
    from .families.power_law import PowerLawFriction as PowerLawFriction
    from .families.registry import FAMILIES as FAMILIES
    from .families.registry import make_model as make_model
    from .loads import DataSet as DataSet
    from .loads import TriboLoads as TriboLoads
    from .loads import load_points as load_points
    from .models.domain import Domain as Domain
    from .models.onnx_model import OnnxModel as OnnxModel
    from .training import Evaluation as Evaluation
    from .training import evaluate as evaluate

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
