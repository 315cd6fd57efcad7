"""Description of a co-simulation: components, connections and time steps, as they stand in a YAML file."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

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
from fmus.runtime.fmu_variables import StartValue
from friction_models.common import nearest, unknown_name, write_text

_MAX_NAME = 100
#: Steps of a component in one communication step.
_MAX_PARTS = 10_000
#: Most communication steps of a run; their results are held in memory.
_MAX_STEPS = 10_000_000
_NAME = re.compile(rf"\w[\w \-+#@()\[\]]{{0,{_MAX_NAME - 1}}}(?<! )")


class TemporaryFolder:
    """A temporary folder of FMUs that lasts as long as a system refers to it."""

    def __init__(self, folder: str | None = None) -> None:
        self.folder = Path(folder or tempfile.mkdtemp(prefix="tribofmu-")).resolve()
        if folder is None:
            weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)

    def __deepcopy__(self, _memo: Any) -> TemporaryFolder:
        return self

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        # Another process borrows the folder; it does not own it.
        return TemporaryFolder, (str(self.folder),)


class Component(BaseModel):
    """One FMU and the start values of its parameters and inputs."""

    model_config = ConfigDict(extra="forbid")

    fmu: Path
    start: dict[str, StartValue] = Field(default_factory=dict)
    #: Run an FMU made for one contact point once for every point of the vectors that feed it. A friction FMU whose variables
    #: are named as in the contract of the loads does so without it.
    each_point: bool | None = None
    #: Keep the loads of points without contact, such as zero pressure, from a friction FMU (`points_without_pressure`).
    contact_only: bool | None = None
    #: Length [s] of the smaller steps that the FMU makes within a communication step, all with the inputs from its beginning.
    step: float | None = Field(default=None, gt=0.0, allow_inf_nan=False)


class SystemDescription(BaseModel):
    """Components, connections, step and stop time of a co-simulation: the data of `orchestrator.System`.

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

    Examples
    --------
    >>> system = SystemDescription.from_dict({
    ...     "communication_step": 0.01, "stop_time": 0.5,
    ...     "components": {"forming": {"fmu": "fre.fmu"}, "friction": {"fmu": "friction.fmu", "step": 0.005}},
    ... })
    >>> system.steps, system.evaluation_order(), system.parts("friction")
    (50, ['friction', 'forming'], 2)
    >>> system.swap("friction", "other.fmu").components["friction"].fmu.name
    'other.fmu'
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
    _temporary: TemporaryFolder | None = PrivateAttr(default=None)

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
    def _whole_steps(self) -> Self:
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
    def from_dict(
        cls, content: dict[str, object], folder: str | os.PathLike[str] = ".", source: str = "system"
    ) -> Self:
        """Build from a mapping as it stands in the YAML file; `folder` is where relative FMU paths start."""
        try:
            system = cls.model_validate(content)
        except ValidationError as error:
            raise collected(source, [_sentence(item) for item in error.errors()]) from None
        system._folder = Path(folder).resolve()
        system._source = source
        return system

    def swap(self, component: str, fmu: str | os.PathLike[str]) -> Self:
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

    def changed(self, **fields: Any) -> Self:
        """Return a copy with other connections, or other values to be recorded."""
        return self.model_copy(update=fields)

    def kept_with(self, folder: TemporaryFolder | None) -> Self:
        """Keep a temporary folder of FMUs as long as this system lasts; return the system."""
        self._temporary = folder
        return self

    @property
    def temporary(self) -> TemporaryFolder | None:
        """Temporary folder with FMUs of this system, where there is one."""
        return self._temporary

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

    def bundle(self, folder: Path) -> dict[str, Path]:
        """Copy the FMUs that live in a temporary folder (from an SSP) into ``folder/fmus``; return them by component."""
        copies: dict[str, Path] = {}
        if self._temporary is None:
            return copies
        for name in self.components:
            path = self.fmu_path(name)
            if path.is_relative_to(self._temporary.folder):
                copies[name] = folder / "fmus" / path.name
                copies[name].parent.mkdir(exist_ok=True)
                shutil.copyfile(path, copies[name])
        return copies

    def to_dict(self, fmus: Mapping[str, str]) -> dict[str, Any]:
        """Return JSON-able data; `fmus` says what stands for the FMU of each component: a path, or a hash."""
        content = self.model_dump(mode="json", exclude_none=True)
        for name, component in content["components"].items():
            component["fmu"] = fmus[name]
        return dict(content)

    def to_yaml(
        self,
        relative_to: str | os.PathLike[str] | None = None,
        moved: Mapping[str, Path] | None = None,
    ) -> str:
        """Return the YAML text; FMU paths absolute, or relative to a folder; `moved`: components whose FMU is elsewhere."""
        paths = {name: (moved or {}).get(name) or self.fmu_path(name) for name in self.components}
        if relative_to:
            paths = {name: Path(os.path.relpath(path, relative_to)) for name, path in paths.items()}
        content = self.to_dict({name: path.as_posix() for name, path in paths.items()})
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
        fields = Component.model_fields if item["loc"][0] == "components" else SystemDescription.model_fields
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
