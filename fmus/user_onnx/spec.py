"""The YAML beside a foreign ONNX file: names, units, ranges, and where each load enters the graph."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from friction_models.common import InputError, nearest, unknown_name
from friction_models.common.wording import kind_of
from friction_models.common.yaml_files import read_yaml
from friction_models.loads import LOAD_NAMES

MAX_SPEC_BYTES = 64 * 1024
Number = Annotated[float, Field(allow_inf_nan=False)]
Text = Annotated[str, Field(max_length=2000)]
Name = Annotated[str, Field(min_length=1, max_length=120)]


class LoadEntry(BaseModel):
    """Where one load enters the graph, and in which form."""

    model_config = ConfigDict(extra="forbid", strict=True)

    column: int | None = Field(default=None, ge=0, le=4)  #: Column of the graph's input, from 0.
    input: Name | None = None  #: Name of the graph's input, where it has several.
    unit: Name | None = None  #: Unit that the graph sees; the contract's by default.
    #: What the model was trained on, in `unit`.
    range: tuple[Number, Number] | None = Field(default=None, strict=False)
    #: Scaling outside the graph: it sees ``(value in unit - subtract) / divide``.
    subtract: Number = 0.0
    divide: Number = 1.0

    @model_validator(mode="after")
    def _sensible(self) -> LoadEntry:
        if self.range is not None and not self.range[0] <= self.range[1]:
            raise ValueError(f"range from {self.range[0]!r} to {self.range[1]!r}; allowed: lower <= upper")
        if abs(self.divide) < 1e-300:
            raise ValueError(f"divide = {self.divide!r}; allowed: a number that is not 0")
        return self


class OutputEntry(BaseModel):
    """Which output is mu, and its scaling: ``mu = multiply * value + add``."""

    model_config = ConfigDict(extra="forbid", strict=True)

    name: Name | None = None
    multiply: Number = 1.0
    add: Number = 0.0


class Spec(BaseModel):
    """What a foreign ONNX file does not say itself; every key may be left out.

    Attributes
    ----------
    name, family, formula, description, author, license : str
        For the FMU's description and documentation; `family` is also part of the binary's name.
    inputs : dict of str to LoadEntry
        By load of the contract. In the file also a list: then the order is that of the columns.

    Examples
    --------
    >>> spec = Spec.from_dict({"inputs": {"T": {"unit": "K"}}, "output": {"multiply": 0.01}})
    >>> spec.inputs["T"].unit, spec.output.multiply
    ('K', 0.01)
    >>> Spec.from_dict({"input": {}})
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: ...
    """

    model_config = ConfigDict(extra="forbid", strict=True)

    name: Name | None = None
    family: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_ -]{0,39}$")] = "onnx"
    formula: Text = ""
    description: Text = ""
    author: Text = ""
    license: Text = ""
    inputs: dict[str, LoadEntry] = Field(default_factory=dict)
    output: OutputEntry = Field(default_factory=OutputEntry)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Spec:
        """Read a YAML file.

        Raises
        ------
        InputError
            No such file, too large, not YAML, unknown keys or loads, values that cannot be used.
        """
        file = Path(path)
        content = read_yaml(file, MAX_SPEC_BYTES, "a YAML file that describes an ONNX file")
        return cls.from_dict(content, str(file))

    @classmethod
    def from_dict(cls, content: object, where: str = "specification") -> Spec:
        """Build from what stands in the YAML file; see `load`."""
        if not isinstance(content, dict) or not all(isinstance(k, str) for k in content):
            raise InputError(
                f"{where}: holds {kind_of(content)}, allowed: the keys {', '.join(cls.model_fields)}"
            )
        if "domain" in content:
            raise InputError(
                f"{where}: unknown key 'domain'; allowed: the trained range stands with each input and in its unit, "
                "for example inputs: {T: {unit: K, range: [293.15, 673.15]}}"
            )
        inputs = content.get("inputs")
        if isinstance(inputs, list):
            content = content | {"inputs": _columns(inputs, where)}
        elif isinstance(inputs, dict):
            content = content | {"inputs": {k: {} if v is None else v for k, v in inputs.items()}}
        named = content.get("inputs")
        for name in named if isinstance(named, dict) else ():
            if name not in LOAD_NAMES:
                raise unknown_name("load in inputs", name, LOAD_NAMES, where)
        try:
            return cls.model_validate(content)
        except ValidationError as error:
            raise InputError(f"{where}: {_sentence(error.errors()[0])}") from None


def _columns(entries: list[Any], where: str) -> dict[str, object]:
    """Return a list of loads as a mapping with columns."""
    found: dict[str, object] = {}
    for k, entry in enumerate(entries):
        one = {"load": entry} if isinstance(entry, str) else entry
        if not isinstance(one, dict) or not isinstance(one.get("load"), str):
            raise InputError(
                f"{where}: inputs[{k}] is {entry!r:.60}, allowed: a load, or {{load: T, unit: K, ...}}"
            )
        if one["load"] in found:
            raise InputError(f"{where}: load {one['load']!r} stands twice in inputs; allowed: once")
        rest = {key: v for key, v in one.items() if key != "load"}
        if "input" not in rest:
            rest = {"column": k} | rest
        found[one["load"]] = rest
    return found


def _sentence(item: Any) -> str:
    """Say one problem that pydantic found, with place, value and the nearest valid key."""
    parts = [str(p) for p in item["loc"]]
    place = ".".join(parts)
    if item["type"] == "extra_forbidden":
        models: dict[str, type[BaseModel]] = {"inputs": LoadEntry, "output": OutputEntry}
        fields = models.get(parts[0], Spec).model_fields if len(parts) > 1 else Spec.model_fields
        hint = nearest(parts[-1], fields)
        guess = f"; did you mean {hint!r}?" if hint else ""
        return f"unknown key {place!r}; allowed: {', '.join(fields)}{guess}"
    text = str(item["msg"]).removeprefix("Value error, ")
    return f"{place}: {text[0].lower() + text[1:]} (value {item['input']!r:.80})"
