"""A friction model as an SSP of one component."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

from friction_models.common import InputError

from ..runtime.fmu_files import describe
from ..targets.packing import pack
from .systems import TYPES, Connector, SspComponent, Structure
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


def single(fmu: str | os.PathLike[str], boundary: bool = False) -> Structure:
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
    description = describe(fmu)
    # An FMI 3.0 array counts as a scalar: SSP 1.0 has no arrays, and ours have one element by default.
    scalars = {v.own: v for v in description.variables.values() if v.type in TYPES}
    connectors = [
        Connector(v.own, kind, v.type, v.unit)
        for kind in ("input", "output")
        for v in scalars.values()
        if v.causality == kind
    ]
    experiment = description.raw.defaultExperiment
    stop, step = (getattr(experiment, key, None) for key in ("stopTime", "stepSize"))
    system = Structure(
        "friction",
        [SspComponent("friction", "resources/friction.fmu", connectors)],
        stop=1.0 if stop is None else float(stop),
        step=0.01 if step is None else float(step),
    )
    if boundary:
        inputs = [c.name for c in connectors if c.kind == "input"]
        outputs = [c.name for c in connectors if c.kind == "output"]
        system.connectors = list(connectors)
        system.connections = [("", n, "friction", n) for n in inputs] + [
            ("friction", n, "", n) for n in outputs
        ]
        for v in (scalars[n] for n in inputs):
            if v.type == "Real" and v.start_text is not None:
                system.start[v.own] = v.starts[0]
    return system
