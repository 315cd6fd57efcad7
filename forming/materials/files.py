"""Material files: YAML with a flow curve in a named form, elasticity, heat data, limits and source."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from friction_models.common import InputError, nearest, unknown_name
from friction_models.common.wording import kind_of
from friction_models.common.yaml_files import number_without_point, read_yaml

from ..fe.heat.properties import Property
from .base import Material, Range
from .flow_curves import FlowTable, HenselSpittel, PowerLaw

SHIPPED = Path(__file__).parent
MAX_BYTES = 1024 * 1024
#: What metals and tool materials have; a value beyond is most often in another unit.
METALS = {
    "density": (500.0, 25_000.0, "kg/m3"),
    "elasticity.E": (1e3, 2e6, "MPa"),
    "conductivity": (0.5, 3000.0, "W/(m K)"),
    "heat_capacity": (50.0, 20_000.0, "J/(kg K)"),
}


#: Flow stress of metals that are formed [MPa], cold or hot, at this strain and this rate [1/s].
FLOW_STRESS, AT_STRAIN, AT_RATE = (1.0, 10_000.0), 0.2, 1.0


Number = Annotated[float, BeforeValidator(number_without_point), Field(allow_inf_nan=False)]
Text = Annotated[str, Field(max_length=4000)]
Axis = Annotated[list[Number], Field(min_length=1, max_length=FlowTable.longest)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class _HenselSpittel(_Part):
    form: Literal["hensel_spittel"]
    A: Number
    m1: Number
    m2: Number
    m3: Number
    m4: Number = 0.0
    m5: Number = 0.0
    m7: Number = 0.0
    m8: Number = 0.0
    m9: Number = 0.0
    strain_floor: Number = 2e-3
    rate_floor: Number = 1e-3


class _RateTemperature(_Part):
    form: Literal["hensel_spittel_rate_temperature"]
    A: Number
    m1: Number
    m2: Number
    m3: Number
    m4: Number
    strain_floor: Number = 2e-3
    rate_floor: Number = 1e-3


class _Gmt(_Part):
    form: Literal["hensel_spittel_gmt"]
    C1: Number
    C2: Number
    n1: Number = 0.0
    n2: Number
    l1: Number = 0.0
    l2: Number = 0.0
    m1: Number = 0.0
    m2: Number
    strain_floor: Number = 2e-3
    rate_floor: Number = 1e-3


class _Constant(_Part):
    form: Literal["constant"]
    stress: Number


class _Ludwik(_Part):
    form: Literal["ludwik"]
    yield_stress: Number
    K: Number
    n: Number
    rate_exponent: Number = 0.0
    reference_rate: Number = 1.0


class _Swift(_Part):
    form: Literal["swift"]
    K: Number
    n: Number
    prestrain: Number
    rate_exponent: Number = 0.0
    reference_rate: Number = 1.0


class _Table(_Part):
    form: Literal["table"]
    strain: Axis
    rate: Axis
    T: Axis
    stress: list[list[list[Number]]]


FORMS: dict[str, type[_Part]] = {
    "hensel_spittel": _HenselSpittel,
    "hensel_spittel_rate_temperature": _RateTemperature,
    "hensel_spittel_gmt": _Gmt,
    "table": _Table,
    "constant": _Constant,
    "ludwik": _Ludwik,
    "swift": _Swift,
}
FlowCurve = Annotated[
    _HenselSpittel | _RateTemperature | _Gmt | _Table | _Constant | _Ludwik | _Swift,
    Field(discriminator="form"),
]


class _OverT(_Part):
    T: Axis
    value: Axis


Heat = Number | _OverT
Limits = Annotated[list[Number], Field(min_length=2, max_length=2)]


class _Valid(_Part):
    strain: Limits | None = None
    rate: Limits | None = None
    T: Limits | None = None


class _Elasticity(_Part):
    E: Number
    nu: Number


class MaterialFile(_Part):
    """Content of a material file; units: MPa, degC, 1/s, kg/m3, W/(m K), J/(kg K)."""

    name: Annotated[str, Field(min_length=1, max_length=80)]
    source: Text
    flow_curve: FlowCurve | None = None
    valid: _Valid = Field(default_factory=_Valid)
    elasticity: _Elasticity
    density: Number
    conductivity: Heat
    heat_capacity: Heat
    taylor_quinney: Number = 0.9
    emissivity: Number = 0.5

    def material(self, where: str) -> Material:
        """Return the material. Raises InputError: values that cannot be."""
        given = (self.density, self.elasticity.E, self.conductivity, self.heat_capacity)
        for (name, (low, high, unit)), found in zip(METALS.items(), given):
            for value in [found] if isinstance(found, float) else found.value:
                if not low <= value <= high:
                    raise InputError(
                        f"{where}: {name} = {value:g} {unit}; allowed: {low:g} to {high:g} {unit} (any metal or tool ceramic)"
                    )
        conductivity = _property(self.conductivity, f"{where}: conductivity")
        cp = _property(self.heat_capacity, f"{where}: heat_capacity")
        try:
            plain = Material(
                name=self.name,
                source=self.source,
                E=self.elasticity.E,
                nu=self.elasticity.nu,
                rho=self.density,
                conductivity=conductivity,
                cp=cp,
                taylor_quinney=self.taylor_quinney,
                emissivity=self.emissivity,
                strain_range=_range(self.valid.strain),
                rate_range=_range(self.valid.rate),
                T_range=_range(self.valid.T),
            )
            return plain if self.flow_curve is None else _checked(_with_flow_curve(plain, self.flow_curve))
        except InputError as error:
            raise InputError(f"{where}: {error}") from None


#: What the coefficients of the GMT spelling are called in `HenselSpittel`.
_GMT_NAMES = {"C1": "A", "C2": "m1", "n2": "m2", "l2": "m4", "m1": "m8", "m2": "m3"}


def _with_flow_curve(plain: Material, curve: FlowCurve) -> Material:
    common, law = vars(plain), curve.model_dump(exclude={"form"})
    if isinstance(curve, _RateTemperature):
        return HenselSpittel(**law, form="rate_temperature", **common)
    if isinstance(curve, _HenselSpittel):
        return HenselSpittel(**law, **common)
    if isinstance(curve, _Gmt):
        return HenselSpittel(**{_GMT_NAMES.get(name, name): value for name, value in law.items()}, **common)
    if isinstance(curve, _Table):
        law = {
            "strains": curve.strain,
            "rates": curve.rate,
            "temperatures": curve.T,
            "stresses": curve.stress,
        }
        return FlowTable(**law, **common)
    if isinstance(curve, _Constant):
        return PowerLaw(yield_stress=curve.stress, **common)
    return PowerLaw(**law, **common)


def _checked(material: Material) -> Material:
    """Return a material with a flow curve. Raises InputError: no metal is so soft or so hard, most often for a wrong unit."""
    T = 20.0 if material.T_range is None else float(np.clip(20.0, *material.T_range))
    stress = float(material.flow_stress(AT_STRAIN, T, AT_RATE))
    low, high = FLOW_STRESS
    if not low <= stress <= high:
        raise InputError(
            f"flow stress = {stress:.4g} MPa at a strain of {AT_STRAIN:g}, {AT_RATE:g} 1/s and {T:g} degC; allowed: {low:g} to {high:g} MPa "
            "(any metal; stresses of a flow curve are in MPa)"
        )
    return material


def _range(limits: list[float] | None) -> Range:
    return None if limits is None else (limits[0], limits[1])


def _property(value: float | _OverT, where: str) -> Property:
    if isinstance(value, float):
        return value
    if len(value.T) != len(value.value):
        raise InputError(
            f"{where}: {len(value.T)} temperatures and {len(value.value)} values; allowed: as many"
        )
    return tuple(zip(value.T, value.value))


def shipped() -> list[str]:
    """Return the names of the shipped materials.

    >>> {"16MnCr5", "1.2379"} <= set(shipped())
    True
    """
    return sorted(file.name.removesuffix(".yaml") for file in SHIPPED.glob("*.yaml"))


def read_material(source: str | os.PathLike[str]) -> Material:
    """Read a shipped material by name, or a YAML file; see `forming.materials.materials.load`."""
    if isinstance(source, str) and source in shipped():
        file = SHIPPED / f"{source}.yaml"
    elif isinstance(source, (str, os.PathLike)) and Path(source).suffix in (".yaml", ".yml"):
        file = Path(source)
    else:
        raise unknown_name("material", str(source), [*shipped(), "the path of a .yaml file"])
    content = read_yaml(file, MAX_BYTES, "a YAML file that describes a material")
    return material_from_content(content, file.name if file.parent == SHIPPED else str(file))


def material_from_content(content: object, where: str = "material") -> Material:
    """Return the material that the content of a file describes.

    Raises InputError: unknown keys, missing ones, or values that cannot be.

    >>> steel = material_from_content(
    ...     {
    ...         "name": "soft steel",
    ...         "source": "an example",
    ...         "flow_curve": {"form": "swift", "K": 700.0, "n": 0.5, "prestrain": 0.25},
    ...         "elasticity": {"E": 210000.0, "nu": 0.3},
    ...         "density": 7850.0,
    ...         "conductivity": 42.0,
    ...         "heat_capacity": {"T": [20.0, 220.0], "value": [460.0, 520.0]},
    ...     }
    ... )
    >>> steel.flow_stress([0.0, 0.75]).round(2).tolist()
    [350.0, 700.0]
    >>> steel.cp
    ((20.0, 460.0), (220.0, 520.0))
    """
    if not isinstance(content, dict) or not all(isinstance(k, str) for k in content):
        raise InputError(
            f"{where}: holds {kind_of(content)}; allowed: the keys {', '.join(MaterialFile.model_fields)}"
        )
    curve = content.get("flow_curve")
    if isinstance(curve, dict) and not (isinstance(curve.get("form"), str) and curve["form"] in FORMS):
        raise unknown_name("form of flow_curve", str(curve.get("form")), FORMS, where)
    try:
        read = MaterialFile.model_validate(content)
    except ValidationError as error:
        found = error.errors()
        # A misspelt key is missing under its right name, too: it is named first.
        first = next((item for item in found if item["type"] == "extra_forbidden"), found[0])
        raise InputError(f"{where}: {_sentence(first)}") from None
    return read.material(where)


def _sentence(item: Any) -> str:
    """Describe one problem that pydantic found: key, value and the nearest valid key."""
    # The discriminator's value and the branch of a union stand in the path, but not in the file.
    keys = [str(p) for p in item["loc"] if str(p) not in {*FORMS, "float", "_OverT"}]
    parts = [k for k in keys if not k.startswith("function-")]
    place = ".".join(parts)
    if item["type"] == "extra_forbidden":
        form = next((str(p) for p in item["loc"] if str(p) in FORMS), "")
        models: dict[str, type[BaseModel]] = {"valid": _Valid, "elasticity": _Elasticity}
        models |= {"flow_curve": FORMS.get(form, _Part), "conductivity": _OverT, "heat_capacity": _OverT}
        fields = (models.get(parts[0], MaterialFile) if len(parts) > 1 else MaterialFile).model_fields
        hint = nearest(parts[-1], fields)
        guess = f"; did you mean {hint!r}?" if hint else ""
        return f"unknown key {place!r}; allowed: {', '.join(fields)}{guess}"
    if item["type"] == "missing":
        return f"{place} is missing; allowed: a value for it"
    text = str(item["msg"]).removeprefix("Value error, ")
    return f"{place} = {item['input']!r:.80}; allowed: {text[0].lower() + text[1:]}"
