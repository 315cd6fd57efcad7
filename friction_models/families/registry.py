"""The families of friction models by name."""

from __future__ import annotations

from typing import Any

from ..common import unknown_name
from ..models.base import FrictionModel
from .constant import ConstantFriction
from .ffnn import FeedForwardFriction
from .gradient_boosting import GradientBoostingFriction
from .linear import LinearFriction
from .polynomial import PolynomialFriction
from .power_law import PowerLawFriction

#: Families that can be trained by name. `linear`, `polynomial` and `ffnn` are the ones that the work
#: this project builds on names; `power_law` (grey box) and `gradient_boosting` (black box) are our choice.
FAMILIES: dict[str, type[FrictionModel]] = {
    c.family: c
    for c in (
        ConstantFriction,
        LinearFriction,
        PolynomialFriction,
        PowerLawFriction,
        GradientBoostingFriction,
        FeedForwardFriction,
    )
}


def model_class(family: str) -> type[FrictionModel]:
    """Return the class of a family that can be trained by name.

    Raises
    ------
    InputError
        Unknown family; the message names the nearest one.

    Examples
    --------
    >>> model_class("power_law").__name__
    'PowerLawFriction'
    """
    if family not in FAMILIES:
        raise unknown_name("model", family, FAMILIES)
    return FAMILIES[family]


def make_model(name: str, **params: Any) -> FrictionModel:
    """Return an unfitted model of the family `name`.

    Raises
    ------
    InputError
        Unknown family or parameter; the message names the nearest one.

    Examples
    --------
    >>> from friction_models import make_model
    >>> make_model("polynomial", degree=3).degree
    3
    >>> make_model("linar")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: unknown model 'linar'; allowed: constant, ffnn, gradient_boosting, linear, polynomial, power_law; did you mean 'linear'?
    """
    kind = model_class(name)
    allowed = kind._get_param_names()
    for param in params:
        if param not in allowed:
            raise unknown_name(f"parameter of {name}", param, allowed)
    return kind(**params)
