"""`pack`: a friction model becomes an FMU."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from numbers import Integral
from pathlib import Path

from friction_models.loads import LOADS, InputError, unknown_name

from .archive import write_archive
from .documentation import card_json, page
from .source import FrictionSource, read_source

TARGETS = ("native", "python")
FMI_VERSIONS = ("2.0",)
#: Most contact points of one FMU.
MAX_NODES = 100_000


def pack(
    model: object,
    path: str | os.PathLike[str],
    target: str = "native",
    nodes: int = 1,
    fmi: str = "2.0",
    platforms: Sequence[str] | None = None,
) -> Path:
    """Write a friction model as an FMU.

    Parameters
    ----------
    model : FrictionModel, path-like
        A model, a folder it was saved to, or an ONNX file.
    path : path-like
        The FMU to write (``.fmu``).
    target : {"native", "python"}
        `native`: C generated from the ONNX graph, needs nothing to run. `python`: ONNX Runtime in
        the Python interpreter of the simulator.
    nodes : int
        Number of contact points; above 1 the variables are ``v_rel[1]`` ... ``v_rel[nodes]``.
    fmi : {"2.0"}
        Version of the standard.
    platforms : sequence of str, optional
        Platforms of a native FMU; this machine's by default.

    Returns
    -------
    Path
        `path`. The same model gives the same bytes.

    Raises
    ------
    InputError
        A model, name or number that cannot be used; an operator that is not translated; no compiler.
    """
    if target not in TARGETS:
        raise unknown_name("target", target, TARGETS)
    version = "2.0" if str(fmi) == "2" else str(fmi)
    if version not in FMI_VERSIONS:
        raise unknown_name("FMI version", fmi, FMI_VERSIONS)
    if isinstance(nodes, bool) or not isinstance(nodes, Integral) or not 1 <= nodes <= MAX_NODES:
        raise InputError(f"nodes = {nodes!r}, allowed: a whole number from 1 to {MAX_NODES}")
    if Path(path).suffix != ".fmu":
        raise InputError(f"{path}: suffix {Path(path).suffix!r}, allowed: '.fmu'")
    source = read_source(model)
    interface = source.interface(int(nodes))
    _check_names(source)
    if target == "native":
        from .native_target import native_files

        files = native_files(source, interface, platforms)
    else:
        if platforms:
            raise InputError(
                "platforms are chosen for --target native only; a Python FMU runs where Python runs"
            )
        from .python_target import friction_files

        files = friction_files(source, interface)
    files |= _documents(source)
    return write_archive(path, files)


def _documents(source: FrictionSource) -> dict[str, bytes]:
    loads = [
        {
            "name": q.name,
            "unit": q.unit,
            "meaning": q.meaning,
            "trained on": source.domain.get(q.name, "not recorded"),
        }
        for q in LOADS
    ]
    sections = {
        "Model": {"family": source.family, "formula": source.formula},
        "Loads": loads,
        "Card": source.card,
    }
    files = {"documentation/index.html": page(f"Friction model {source.name}", sections)}
    if source.card:
        files["documentation/card.json"] = card_json(source.card)
    return files


def _check_names(source: FrictionSource) -> None:
    taken = {q.name for q in LOADS} | {"mu", "domain_distance", "in_domain", "clamp_to_domain"}
    for name in [s.name for s in source.states] + [p.name for p in source.system]:
        if name in taken or not re.fullmatch(r"[A-Za-z_]\w*", name, flags=re.ASCII):
            raise InputError(
                f"{source.where}: state or system variable {name!r} cannot be an FMI variable; "
                f"allowed: a plain name that is not yet taken ({', '.join(sorted(taken))})"
            )
        taken.add(name)
