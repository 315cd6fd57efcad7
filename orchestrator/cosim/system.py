"""The system description: components, connections and the clock of a co-simulation, as YAML."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationError,
    field_validator,
    model_validator,
)

from fmus.runtime.errors import collected
from friction_models.common import InputError, nearest, unknown_name, write_text
from friction_models.common.yaml_files import read_yaml

from .ssp_systems import UnpackedSsp, export_ssp, load_ssp

_MAX_NAME = 100
#: A system is a page of text; start values of a thousand points still fit.
_MAX_BYTES = 4_000_000
#: Steps of a component in one communication step.
_MAX_PARTS = 10_000
#: Most communication steps of a run; their results are held in memory.
_MAX_STEPS = 10_000_000
_NAME = re.compile(rf"\w[\w \-+#@()\[\]]{{0,{_MAX_NAME - 1}}}(?<! )")

StartValue = bool | int | float | str | list[float]


class Component(BaseModel):
    """One FMU and the start values of its parameters and inputs.

    `each_point` lets an FMU of one contact point run once a point of the vectors that feed it; a friction FMU
    with the variables of the contract needs no such word. `contact_only` spares a friction FMU the loads of points that
    have not touched anything yet, zero pressure above all (see `untouched`). `step` lets an FMU make several smaller steps [s] in each
    communication step, all with the inputs that it got at its beginning.
    """

    model_config = ConfigDict(extra="forbid")

    fmu: Path
    start: dict[str, StartValue] = Field(default_factory=dict)
    each_point: bool | None = None
    contact_only: bool | None = None
    step: float | None = Field(default=None, gt=0.0, allow_inf_nan=False)


class System(BaseModel):
    """Components, connections, step and stop time of a co-simulation.

    Attributes
    ----------
    name : str
        Name of the system.
    communication_step, stop_time : float
        Fixed step and end of the run [s]; the stop time is a whole number of steps.
    components : dict of str to Component
        FMU files and start values; file names are relative to the YAML file.
    connections : list of str
        ``"forming.v_rel -> friction.v_rel"``; structured variables connect element by element. A unit behind the
        target, ``"forming.T -> friction.T_contact [K]"``, converts a load. A scalar friction
        FMU fed by a vector runs once a contact point; arrays of FMI 3.0 whose length is a structural parameter
        become as long as what feeds them.
    order : list of str or None
        Order of evaluation in the mode ``gauss_seidel``; None: a component named ``friction`` first,
        the others as they stand in the file.
    record : list of str or None
        What the run keeps (``"forming.force"``); None: all outputs.
    synthetic : bool
        Whether something in the system comes from a virtual laboratory; goes into every run.
    provenance : dict
        Remarks that the run's manifest repeats (seed, level, label of the friction model).
    """

    model_config = ConfigDict(extra="forbid")

    name: str = "system"
    communication_step: float = Field(gt=0.0, allow_inf_nan=False)
    stop_time: float = Field(gt=0.0, allow_inf_nan=False)
    components: dict[str, Component] = Field(min_length=1)
    connections: list[str] = Field(default_factory=list)
    order: list[str] | None = None
    record: list[str] | None = None
    synthetic: bool = False
    provenance: dict[str, bool | int | float | str] = Field(default_factory=dict)

    _folder: Path = PrivateAttr(default_factory=Path.cwd)
    _source: str = PrivateAttr(default="system")
    _unpacked: UnpackedSsp | None = PrivateAttr(default=None)

    @field_validator("components")
    @classmethod
    def _plain_names(cls, components: dict[str, Component]) -> dict[str, Component]:
        # Names become parts of paths, of connections and of archives.
        for name in components:
            if not _NAME.fullmatch(name):
                raise ValueError(
                    f"component name {name!r} cannot be used; allowed: letters, digits, spaces and _-+#@()[] "
                    f"after a letter or digit, at most {_MAX_NAME} characters"
                )
        return components

    @model_validator(mode="after")
    def _whole_steps(self) -> System:
        steps = self.stop_time / self.communication_step
        if not steps <= _MAX_STEPS:
            raise ValueError(
                f"stop_time {self.stop_time:g} s is {steps:.3g} communication steps of {self.communication_step:g} s; "
                f"allowed: at most {_MAX_STEPS}"
            )
        if abs(steps - round(steps)) > 1e-6 * max(1.0, steps) or round(steps) < 1:
            raise ValueError(
                f"stop_time {self.stop_time:g} s is not a whole number of communication steps of {self.communication_step:g} s"
            )
        for name, component in self.components.items():
            parts = self.communication_step / (component.step or self.communication_step)
            if parts > _MAX_PARTS + 0.5:
                raise ValueError(
                    f"component {name!r}: step {component.step:g} s is {parts:.3g} steps in each communication step of "
                    f"{self.communication_step:g} s; allowed: 1 to {_MAX_PARTS}"
                )
            if round(parts) < 1 or abs(parts - round(parts)) > 1e-6 * max(1.0, parts):
                raise ValueError(
                    f"component {name!r}: step {component.step:g} s does not divide the communication step of "
                    f"{self.communication_step:g} s; allowed: that over a whole number"
                )
        return self

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> System:
        """Read a YAML file, whose FMU paths are relative to it, or an SSP archive (``.ssp``).

        Raises
        ------
        InputError
            No such file, not YAML, unknown or missing keys, values out of range; all problems at once.
            What `load_ssp` refuses.
        """
        file = Path(path)
        if not file.is_file():
            raise InputError(f"{file}: no such file")
        if file.suffix.lower() == ".ssp":
            return load_ssp(file)
        if file.stat().st_size > _MAX_BYTES:
            raise InputError(f"{file}: {file.stat().st_size} bytes; allowed: at most {_MAX_BYTES}")
        content = read_yaml(file)
        if content is None:
            raise InputError(f"{file}: the file is empty")
        if not isinstance(content, dict):
            raise InputError(f"{file}: a system is a mapping, not a {type(content).__name__}")
        return cls.from_dict(content, file.resolve().parent, str(file))

    @classmethod
    def from_dict(
        cls, content: dict[str, Any], folder: str | os.PathLike[str] = ".", source: str = "system"
    ) -> System:
        """Build from a mapping as it stands in the YAML file; `folder` is where relative FMU paths start."""
        try:
            system = cls.model_validate(content)
        except ValidationError as error:
            raise collected(source, [_sentence(item) for item in error.errors()]) from None
        system._folder = Path(folder).resolve()
        system._source = source
        return system

    def swap(self, component: str, fmu: str | os.PathLike[str]) -> System:
        """Return a copy in which one component runs another FMU; nothing else changes.

        Raises
        ------
        InputError
            No component of that name.
        """
        if component not in self.components:
            raise unknown_name("component", component, self.components, self._source)
        copy = self.model_copy(deep=True)
        copy.components[component].fmu = Path(fmu).resolve()
        return copy

    def _with_unpacked(self, unpacked: UnpackedSsp | None) -> System:
        """Keep a temporary folder of FMUs as long as this system lasts."""
        self._unpacked = unpacked
        return self

    def _changed(self, **fields: Any) -> System:
        """Return a copy with other connections, or other values to be recorded."""
        return self.model_copy(update=fields)

    def fmu_path(self, component: str) -> Path:
        """Return the absolute path of a component's FMU."""
        return (self._folder / self.components[component].fmu).resolve()

    @property
    def source(self) -> str:
        """Where the description came from, for messages."""
        return self._source

    @property
    def steps(self) -> int:
        """Number of communication steps of the run."""
        return round(self.stop_time / self.communication_step)

    def parts(self, component: str) -> int:
        """Return how many steps a component makes in each communication step."""
        return round(self.communication_step / (self.components[component].step or self.communication_step))

    def evaluation_order(self) -> list[str]:
        """Return the components in the order in which `gauss_seidel` evaluates them."""
        if self.order is not None:
            return list(self.order)
        return sorted(self.components, key=lambda name: name != "friction")

    def validate(self) -> None:  # type: ignore[override]
        """Open every FMU and check the whole set-up.

        Raises
        ------
        InputError
            Lists all problems at once: names, units, lengths, unconnected inputs, unreadable FMUs.
        """
        from .setup.wiring import Wiring

        Wiring.of(self)

    def export(self, path: str | os.PathLike[str], boundary: bool = False) -> Path:
        """Write the system and its FMUs as an SSP 1.0 archive; see `export_ssp`."""
        return export_ssp(self, path, boundary)

    def bundle(self, folder: Path) -> dict[str, Path]:
        """Copy the FMUs that live in a temporary folder (from an SSP) into ``folder/fmus``; return them by component."""
        copies: dict[str, Path] = {}
        for name in self.components if self._unpacked is not None else ():
            path = self.fmu_path(name)
            if self._unpacked is not None and path.is_relative_to(self._unpacked.folder):
                copies[name] = folder / "fmus" / path.name
                copies[name].parent.mkdir(exist_ok=True)
                shutil.copyfile(path, copies[name])
        return copies

    def to_yaml(
        self,
        relative_to: str | os.PathLike[str] | None = None,
        moved: Mapping[str, Path] | None = None,
    ) -> str:
        """Return the YAML text; FMU paths absolute, or relative to a folder; `moved`: components whose FMU is elsewhere."""
        content = self.model_dump(mode="json", exclude_none=True)
        for name, component in content["components"].items():
            path = (moved or {}).get(name) or self.fmu_path(name)
            component["fmu"] = Path(os.path.relpath(path, relative_to) if relative_to else path).as_posix()
        return str(yaml.safe_dump(content, sort_keys=False, allow_unicode=True))

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the YAML file, with FMU paths relative to its folder; FMUs of an SSP go into ``fmus`` beside it."""
        file = Path(path).resolve()
        file.parent.mkdir(parents=True, exist_ok=True)
        return write_text(file, self.to_yaml(relative_to=file.parent, moved=self.bundle(file.parent)))


def _sentence(item: Any) -> str:
    """One problem that pydantic found, in a sentence with place, value and the nearest valid key."""
    place = ".".join(str(part) for part in item["loc"])
    if item["type"] == "extra_forbidden":
        fields = Component.model_fields if item["loc"][0] == "components" else System.model_fields
        key = str(item["loc"][-1])
        hint = nearest(key, fields)
        guess = f"; did you mean {hint!r}?" if hint else ""
        return f"unknown key {place!r}; allowed: {', '.join(fields)}{guess}"
    if item["type"] == "missing":
        return f"the key {place!r} is missing"
    text = str(item["msg"]).removeprefix("Value error, ")
    text = text[0].lower() + text[1:]
    shown = "" if isinstance(item["input"], dict) else f" (value {item['input']!r})"
    return f"{place}: {text}{shown}" if place else text
