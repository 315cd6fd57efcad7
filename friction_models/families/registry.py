"""The families of friction models by name."""

from __future__ import annotations

from typing import Any

from ..common import unknown_name
from ..common.imports.plugins import offered
from ..models.base import FrictionModel
from .constant import ConstantFriction
from .ffnn import FeedForwardFriction
from .formula import FormulaFriction
from .gradient_boosting import GradientBoostingFriction
from .linear import LinearFriction
from .polynomial import PolynomialFriction
from .power_law import PowerLawFriction

ENTRY_POINT_GROUP = "tribofmu.families"

#: `linear`, `polynomial` and `ffnn` are the families that the work this project builds on names; `power_law` (grey box)
#: and `gradient_boosting` (black box) are our choice.
_OWN: tuple[type[FrictionModel], ...] = (
    ConstantFriction,
    LinearFriction,
    PolynomialFriction,
    PowerLawFriction,
    GradientBoostingFriction,
    FeedForwardFriction,
)


def load_families() -> dict[str, type[FrictionModel]]:
    """Return the own families and those of installed packages by the name that each declares as `family`.

    Examples
    --------
    >>> load_families()["linear"].__name__
    'LinearFriction'
    """
    families = {kind.family: kind for kind in _OWN}

    def fault(kind: Any) -> str | None:
        if not (isinstance(kind, type) and issubclass(kind, FrictionModel)):
            return "not a FrictionModel class"
        if not isinstance(kind.family, str) or not kind.family:
            return f"family = {kind.family!r:.40}; allowed: a text"
        return f"the name {kind.family!r} is taken" if kind.family in families else None

    for kind in offered(ENTRY_POINT_GROUP, "family", fault):
        families[kind.family] = kind
    return families


#: Families that can be trained by name.
FAMILIES = load_families()


def model_class(family: str) -> type[FrictionModel]:
    """Return the class of a family that can be trained by name.

    Raises InputError: unknown family; the message names the nearest one.

    Examples
    --------
    >>> model_class("power_law").__name__
    'PowerLawFriction'
    """
    # No family to be trained by name: without a formula there is nothing to fit.
    if family == FormulaFriction.family:
        return FormulaFriction
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
