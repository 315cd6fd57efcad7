"""The families of friction models, one file each; sums of a family and effects; the registry; reading saved models."""

from ..models.base import FrictionModel
from .composed import ComposedFriction
from .loading import load_model
from .registry import FAMILIES, make_model

__all__ = ["FAMILIES", "ComposedFriction", "FrictionModel", "load_model", "make_model"]
