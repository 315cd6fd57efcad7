"""Exchange of the model of a component: for an FMU, a model folder, an ONNX file or a constant friction coefficient."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import fmus
from fmus.runtime.fmu_files import describe
from fmus.runtime.friction_names import FrictionNames
from friction_models import ConstantFriction
from friction_models.cards import is_card
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, MU

from .setup.connections import split_connection
from .setup.description import TemporaryFolder
from .system import System

#: Outputs and parameters that friction FMUs of ours have and others need not.
_OWN = ("domain_distance", "in_domain", "mu_low", "mu_high", "clamp_to_domain")
_HELP = (
    "for an FMU with other variables --names FILE.yaml says which takes which load, and in the system each_point: true "
    "lets one for a single point run once a point"
)


def swap_model(
    system: System,
    component: str,
    model: str | os.PathLike[str],
    names: FrictionNames | None = None,
    packed: Path | None = None,
) -> System:
    """Return a copy of a system in which a component runs another model; nothing else changes.

    A component that takes loads and gives mu may get any friction model: an FMU, a model folder, an ONNX file, a card
    (``card:NAME``), or a number for constant mu; any other one another FMU. Connections are made to fit the variables of
    an FMU that others made, which `names` names. What is no FMU is written to `packed`; by default into a temporary
    folder, from which runs and archives get copies.
    """
    other = system.swap(component, model)  # a name that is wrong is said before anything is packed
    text = os.fspath(model)
    if _is_packed(text):
        if packed is None:
            folder = other.temporary or TemporaryFolder()
            other.kept_with(folder)
            plain = re.sub(r"[^\w.-]", "_", Path(text).name)[:60]
            packed = folder.folder / f"{component}-{plain}.fmu"
        other = system.swap(component, friction_fmu(text, packed)).kept_with(other.temporary)
    if not takes_loads(system, component):
        return other
    return _fitted(other, component, names)


def friction_fmu(model: str, target: Path, nodes: int | None = None) -> Path:
    """Return the friction FMU of a model folder, an ONNX file, a card or a number; an FMU is taken as it is.

    Without a number of nodes it is one of FMI 3.0, whose arrays become as long as what feeds them.

    Examples
    --------
    >>> friction_fmu("no-such.fmu", Path("packed.fmu"))
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: no-such.fmu: no such FMU
    """
    size: dict[str, Any] = {"fmi": "3.0", "arrays": True} if nodes is None else {"nodes": nodes}
    if is_card(model):
        return fmus.pack(model, target, **size)
    if Path(model).suffix == ".fmu":
        describe(model)
        return Path(model)
    try:
        constant = float(model)
    except ValueError:
        return fmus.pack(Path(model), target, **size)
    return fmus.pack(ConstantFriction(constant), target, **size)


def takes_loads(system: System, component: str) -> bool:
    """Whether a component is a friction model: loads of the contract go in and mu comes out.

    Examples
    --------
    >>> system = System.from_dict({
    ...     "communication_step": 0.01, "stop_time": 0.5,
    ...     "components": {"law": {"fmu": "law.fmu"}, "forming": {"fmu": "fre.fmu"}},
    ...     "connections": ["forming.sigma_n -> law.sigma_n", "law.mu -> forming.mu"],
    ... })
    >>> takes_loads(system, "law"), takes_loads(system, "forming"), friction_component(system)
    (True, False, 'law')
    """
    loads, mu = False, False
    for left, right, _ in filter(None, map(_ends, system.connections)):
        loads = loads or (right[0] == component and _load(left[1], right[1]) is not None)
        mu = mu or (left[0] == component and MU.name in {_base(left[1]), _base(right[1])})
    return loads and mu


def friction_component(system: System) -> str:
    """Return the component that is a friction model: the only one, or the one called ``friction``."""
    found = [name for name in system.components if takes_loads(system, name)]
    if "friction" in found or len(found) == 1:
        return "friction" if "friction" in found else found[0]
    what = f"{', '.join(found)} do" if found else "none does"
    raise InputError(
        f"{system.source}: components that take loads and give mu: {what}; allowed: one, or one called 'friction'"
    )


def _fitted(system: System, component: str, names: FrictionNames | None) -> System:
    """Make connections, start values and what is recorded fit the friction FMU that a component runs now."""
    called = names or FrictionNames()
    description = describe(system.fmu_path(component))
    part = system.components[component]
    connections, ours = [], {MU.name: called.mu}
    for text in system.connections:
        ends = _ends(text)
        if ends is None:
            connections.append(text)
            continue
        (source, output), (target, given), unit = ends
        load = _load(output, given) if target == component else None
        if load is not None:
            if load not in called.loads:
                continue  # it does not enter the FMU
            variable, wanted = called.loads[load]
            if names is None and _base(given) not in description.arrays:
                variable = given  # a system that was written for it, or a mistake that is told below
            keeps = unit if names is None and _base(given) != load else wanted
            text = f"{_joined(source, output)} -> {component}.{variable}{_index(given)}" + (
                f" [{keeps}]" if keeps else ""
            )
            _check(description, variable, "input", names)
        elif source == component and MU.name in {_base(output), _base(given)}:
            ours[_base(output)] = called.mu
            text = f"{component}.{called.mu}{_index(output)} -> {_joined(target, given)}"
            _check(description, called.mu, "output", names)
        connections.append(text)
    part.start = {
        k: v for k, v in part.start.items() if k not in _OWN or k in description.arrays
    } | dict(called.start)  # fmt: skip
    if names is not None:
        part.each_point = called.each_point or None
        part.contact_only = True  # it may have no answer to zero pressure
    record: list[str] | None = None if system.record is None else []
    for text in system.record or ():
        owner, _, name = text.strip().partition(".")
        base = ours.get(_base(name), _base(name))
        if record is not None and not (
            owner == component and base in _OWN and base not in description.arrays
        ):
            record.append(f"{owner}.{base}{_index(name)}" if owner == component else text)
    return system.changed(connections=connections, record=record)


def _check(description: object, variable: str, causality: str, names: FrictionNames | None) -> None:
    try:
        description.resolve(variable, causality, causality)  # type: ignore[attr-defined]
    except InputError as error:
        if names is not None:
            raise
        raise InputError(f"{error}; {_HELP}") from None


def _is_packed(text: str) -> bool:
    """Whether a model is none that runs as it is: a number, a card, a model folder or an ONNX file."""
    if is_card(text) or Path(text).suffix == ".onnx" or Path(text).is_dir():
        return True
    try:
        float(text)
    except ValueError:
        return False
    return not Path(text).is_file()


def _ends(text: str) -> tuple[tuple[str, str], tuple[str, str], str] | None:
    """Return component and variable of both ends of a connection, and its unit; None for what is none."""
    parts = split_connection(text)
    if parts is None:
        return None
    left, right = (end.partition(".") for end in parts[:2])
    return (left[0], left[2]), (right[0], right[2]), parts[2]


def _joined(component: str, variable: str) -> str:
    return f"{component}.{variable}" if variable else component


def _load(source: str, target: str) -> str | None:
    """Return the load that a connection carries, by the name of either end."""
    return next((n for n in (_base(target), _base(source)) if n in LOAD_NAMES), None)


def _base(name: str) -> str:
    return name.partition("[")[0]


def _index(name: str) -> str:
    return name[len(_base(name)) :]
