"""Materials by object, by name, from a file or from a dictionary."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import MISSING, fields, replace
from functools import lru_cache
from typing import Any, Literal

from friction_models.common import InputError, unknown_name

from .base import Material
from .flow_curves import FlowTable, HenselSpittel, PowerLaw

KINDS: dict[str, type[Material]] = {c.__name__: c for c in (HenselSpittel, PowerLaw, FlowTable, Material)}


def material_from_dict(content: Mapping[str, Any]) -> Material:
    """Return the material that `Material.to_dict` described; without a kind: Hensel-Spittel.

    Raises InputError: an unknown kind or parameter, a missing one, or a value outside its limits.

    >>> material_from_dict({"kind": "PowerLaw", "yield_stress": 400.0, "name": "soft"}).name
    'soft'
    >>> steel = steel_16MnCr5()
    >>> material_from_dict(steel.to_dict()) == steel
    True
    """
    given = dict(content)
    kind = given.pop("kind", "HenselSpittel")
    if kind not in KINDS:
        raise unknown_name("kind of material", kind, KINDS)
    known = [f.name for f in fields(KINDS[kind])]
    for name in given:
        if name not in known:
            raise unknown_name("parameter of a material", name, known)
    for f in fields(KINDS[kind]):
        if f.name not in given and f.default is MISSING and f.default_factory is MISSING:
            raise InputError(f"material: {f.name} is missing; allowed: a value for it")
    return KINDS[kind](**given)


def load(source: str | os.PathLike[str]) -> Material:
    """Return a material by the name of a shipped file (``"16MnCr5"``, ``"1.2379"``) or the path of a YAML file.

    Raises InputError: no such material or file, or a file that cannot be used; names key, value and what is allowed.

    >>> load("16MnCr5").name
    '16MnCr5'
    >>> load("16MnCr")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: unknown material '16MnCr'; allowed: ...; did you mean '16MnCr5'?
    """
    from .files import read_material

    return read_material(source)


#: How a material is given: itself, the name of a shipped one, the path of a file, or what `to_dict` returned.
MaterialSource = Material | str | float | os.PathLike[str] | Mapping[str, Any] | None


def as_material(material: MaterialSource, name: str = "material") -> Material:
    """Return a material as it is, or by name or path; None: 16MnCr5. `name` is that of the parameter.

    Raises InputError: something else, or see `load`.

    >>> as_material("1.2379").name
    '1.2379'
    >>> as_material(None) == steel_16MnCr5()
    True
    """
    if material is None:
        return steel_16MnCr5()
    if isinstance(material, Material):
        return material
    if isinstance(material, float) and math.isfinite(material):
        material = repr(material)  # numbers of steels, which YAML and command lines read as such
    if isinstance(material, (str, os.PathLike)):
        return load(material)
    if isinstance(material, Mapping):
        return material_from_dict(material)
    raise InputError(
        f"{name} = {material!r:.60}; allowed: a material, the name of a shipped one, or the path of a file"
    )


def steel_16MnCr5(form: Literal["inverse_strain", "rate_temperature"] = "inverse_strain") -> HenselSpittel:
    """Return case-hardening steel 16MnCr5 (1.7131) with the coefficients of the paper; handbook heat data.

    The two readings of the fifth coefficient differ by +0.4 % at 20 degC and +8 % at 200 degC and 100/s.

    Examples
    --------
    >>> steel_16MnCr5().form
    'inverse_strain'
    >>> steel_16MnCr5("rate_temperature").form
    'rate_temperature'
    """
    return replace(_shipped_16MnCr5(), form=form)


@lru_cache(maxsize=1)
def _shipped_16MnCr5() -> HenselSpittel:
    steel = load("16MnCr5")
    assert isinstance(steel, HenselSpittel)
    return steel
