"""A friction model as an SSP of one component."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

from lxml import etree

from friction_models.common import InputError

from ..archive.content import read_description
from ..targets.packing import pack
from .systems import TYPES, Component, Connector, Structure, Value
from .writing import write_ssp


def pack_ssp(model: object, path: str | os.PathLike[str], boundary: bool = False, **options: Any) -> Path:
    """Write a friction model as an SSP of one component.

    Parameters
    ----------
    model : FrictionModel, path-like
        What `pack` takes.
    path : path-like
        The archive (``.ssp``).
    boundary : bool
        Make loads, with their start values, and outputs those of the system, too. Tools that turn an SSP into one FMU need that;
        libcosim and ecos refuse connections to the system itself.
    **options
        Of `pack`: `target`, `nodes`, `fmi`, `platforms`.

    Raises
    ------
    InputError
        What `pack` and `write_ssp` refuse.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from fmus.ssp.reading import read_ssp
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     structure = read_ssp(pack_ssp(ConstantFriction(mu=0.1), Path(place) / "law.ssp", target="python"))
    ...     [(c.name, c.source) for c in structure.components]
    [('friction', 'resources/friction.fmu')]
    """
    if Path(path).suffix != ".ssp":
        raise InputError(f"{path}: suffix {Path(path).suffix!r}, allowed: '.ssp'")
    with tempfile.TemporaryDirectory(prefix="tribofmu-") as folder:
        fmu = pack(model, Path(folder) / "friction.fmu", **options)
        return write_ssp(path, single(fmu, boundary=boundary), {"resources/friction.fmu": fmu})


def single(fmu: str | os.PathLike[str], name: str = "friction", boundary: bool = False) -> Structure:
    """Return the structure of a system that is this FMU alone; with `boundary` its variables are the system's.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     structure = single(pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python"))
    >>> [c.name for c in structure.components[0].connectors][:5]
    ['v_rel', 'T', 'sigma_n', 'sd', 'psi']
    """
    root = read_description(fmu)
    variables, starts = scalars(root)
    inputs, outputs = [], []
    for variable in variables:
        if variable.kind == "input":
            inputs.append(variable)
        elif variable.kind == "output":
            outputs.append(variable)
    experiment = root.find("DefaultExperiment")
    given = {} if experiment is None else dict(experiment.attrib)
    links = [("", c.name, name, c.name) for c in inputs] + [(name, c.name, "", c.name) for c in outputs]
    return Structure(
        name,
        [Component(name, f"resources/{name}.fmu", [*inputs, *outputs])],
        links if boundary else [],
        [*inputs, *outputs] if boundary else [],
        {c.name: starts[c.name] for c in inputs if c.name in starts} if boundary else {},
        stop=float(given.get("stopTime", 1.0)),
        step=float(given.get("stepSize", 0.01)),
    )


def scalars(root: etree._Element) -> tuple[list[Connector], dict[str, Value]]:
    """Return the inputs, outputs and parameters of a model description (FMI 2.0 or 3.0) as connectors.

    With them the start values of those that are Real. An FMI 3.0 array counts as a scalar: SSP 1.0 has no arrays, and ours have one element by default.
    """
    declared = {t.get("name"): t for t in root.iter("SimpleType")}
    declared |= {t.get("name"): t for t in root.iterfind("TypeDefinitions/*") if t.tag.endswith("Type")}
    found: list[Connector] = []
    starts: dict[str, Value] = {}
    for variable in root.iterfind("ModelVariables/*"):
        kind = variable.get("causality")
        if kind not in {"input", "output", "parameter"}:
            continue
        typed = variable if variable.tag != "ScalarVariable" else next(iter(variable))
        name = str(typed.tag)
        kinds = {"Float64": "Real", "Float32": "Real"}
        name = kinds.get(name, "Integer" if "Int" in name else name)
        if name not in TYPES:
            continue
        definition = declared.get(typed.get("declaredType"))
        units = [typed.get("unit")]
        if definition is not None:
            units += [definition.get("unit"), *(e.get("unit") for e in definition)]
        unit = next((u for u in units if u), "")
        found.append(Connector(str(variable.get("name")), kind, name, unit))
        if name == "Real" and typed.get("start"):
            starts[found[-1].name] = float(str(typed.get("start")).split()[0])
    return found, starts
