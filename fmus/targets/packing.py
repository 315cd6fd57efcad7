"""`pack`: a friction model becomes an FMU."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Sequence
from dataclasses import replace
from numbers import Integral
from pathlib import Path
from typing import Any

from friction_models.common import InputError, unknown_name
from friction_models.common.wording import counted
from friction_models.loads import LOADS
from friction_models.models.model_card import seen_by_card

from ..archive.content import write_archive
from ..archive.made_here import remember
from ..exports import TARGETS as EXPORT_TARGETS
from ..exports import export
from ..exports.common import checked_options
from ..interface.description import c_identifier
from ..interface.friction_source import FrictionSource
from ..interface.friction_variables import MAX_NODES
from ..interface.friction_variables import NAMES as FMI3_NAMES
from ..interface.ls_struct import map_axes
from ..interface.quantities import parameter_arrays
from ..pages.friction_page import friction_documents
from ..source.reading import read_source

FMI_VERSIONS = ("2.0", "3.0")
#: The first three are FMUs; those of `fmus.exports` are folders of sources or tables.
TARGETS = ("native", "python", "map", *EXPORT_TARGETS)
#: What the card of an FMU takes over from a diagnosis; the whole answer stays in its file, which the digest names.
_TAKEN = ("verdict", "sentence", "effects", "confusion_set", "confidence", "model", "synthetic")
#: Longest name of an FMU: it names files and functions.
_MAX_NAME = 64


def pack(
    model: object,
    path: str | os.PathLike[str],
    target: str = "native",
    nodes: int = 1,
    fmi: str | None = None,
    platforms: Sequence[str] | None = None,
    spec: str | os.PathLike[str] | None = None,
    interval: bool = False,
    arrays: bool = False,
    name: str | None = None,
    diagnosis: str | os.PathLike[str] | None = None,
    **options: Any,
) -> Path:
    """Write a friction model as an FMU, or as sources or a table for codes that load no FMUs.

    Parameters
    ----------
    model : FrictionModel, path-like, FrictionSource
        A model, a card (``card:NAME``), a folder a model was saved to, or an ONNX file, also one from elsewhere; or what `read_source`
        made of one.
    path : path-like
        The FMU to write (``.fmu``); the folder to write for the other targets.
    target : str
        `native`: C generated from the ONNX graph, needs nothing to run. `python`: ONNX Runtime in
        the Python interpreter of the simulator. `map`: a native FMU of FMI 3.0 whose mu comes from a map over up to three
        loads that is a parameter (`fmus.targets.friction_map`). The others: see `fmus.exports`.
    nodes : int
        Number of contact points; above 1 the variables of FMI 2.0 are ``v_rel[1]`` ... ``v_rel[nodes]``,
        while FMI 3.0 has arrays whose length ``n`` starts at `nodes` and can be set by the simulator.
    fmi : {"2.0", "3.0"}, optional
        Version of the standard; ``"2"`` and ``"3"`` will do. By default 2.0, for a map 3.0, which has arrays.
    platforms : sequence of str, optional
        Platforms of a native FMU (`fmus.native.platforms`, or ``all``); this machine's by default.
    spec : path-like, optional
        YAML file that says what the columns of an ONNX file from elsewhere mean.
    interval : bool
        Whether the FMU has the outputs `mu_low` and `mu_high`: the bounds of the model's prediction interval.
    arrays : bool
        FMI 3.0: whether one point has arrays of a length that can be set, too, instead of scalars, which more
        simulators load.
    name : str, optional
        Name of the model and C identifier of the FMU (`modelIdentifier`); by default the identifier is made of the
        family and a hash of the content, so that no two models share it.
    diagnosis : path-like, optional
        What ``diagnose --json`` wrote: its verdict goes into the card and the metadata that are packed with the model.
    **options
        Of the targets of `fmus.exports`, and of `map`.

    Returns
    -------
    Path
        `path`. The same model gives the same bytes.

    Raises
    ------
    InputError
        A model, name or number that cannot be used; an operator that is not translated; no compiler.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import read_friction_fmu
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     fmu = pack(ConstantFriction(mu=0.1), Path(place) / "friction.fmu", target="python")
    ...     model = read_friction_fmu(fmu)
    ...     model.nodes, model.formula_text()
    (1, 'mu = 0.1')
    """
    if target not in TARGETS:
        raise unknown_name("target", target, TARGETS)
    given = ("3.0" if target == "map" else "2.0") if fmi is None else str(fmi)
    version = {"2": "2.0", "3": "3.0"}.get(given, given)
    if version not in FMI_VERSIONS:
        raise unknown_name("FMI version", fmi, FMI_VERSIONS)
    if isinstance(nodes, bool) or not isinstance(nodes, Integral) or not 1 <= nodes <= MAX_NODES:
        raise InputError(f"nodes = {nodes!r}, allowed: a whole number from 1 to {MAX_NODES}")
    if target in EXPORT_TARGETS:
        if interval:
            raise InputError(
                f"interval: target {target!r} has no prediction interval; allowed: native, python"
            )
        if name is not None or arrays:
            given = f"name = {name!r}" if name is not None else "arrays"
            raise InputError(f"{given}: belongs to an FMU; target {target!r} has none")
        if nodes != 1 or version != "2.0" or platforms:
            raise InputError(
                f"nodes, FMI version and platforms are those of an FMU; target {target!r} has none"
            )
        if Path(path).suffix == ".fmu":
            raise InputError(f"{path}: target {target!r} writes a folder, allowed: a name without '.fmu'")
        return export(_read(model, spec, target, diagnosis), path, target, **options)
    if options and target != "map":
        option = next(iter(options))
        raise InputError(f"{option} = {options[option]!r} is no option of target {target!r}; allowed: none")
    if Path(path).suffix != ".fmu":
        raise InputError(f"{path}: suffix {Path(path).suffix!r}, allowed: '.fmu'")
    if name is not None:
        _check_identifier(name)
    if arrays and version != "3.0":
        raise InputError(f"arrays with FMI version {version!r}, allowed: '3.0' (FMI 2.0 has scalars only)")
    source = _read(model, spec, target, diagnosis)
    if target == "map":
        if version != "3.0" or interval:
            wrong = "interval" if interval else f"FMI version {version!r}"
            raise InputError(
                f"{wrong} of target 'map', allowed: FMI 3.0, which has arrays, without an interval"
            )
        source = as_map(source, **options)
        target = "native"
    interface = source.interface(int(nodes), bool(interval), bool(arrays))
    _check_names(source)
    if target == "native":
        from .native import native_files

        files = native_files(source, interface, platforms, version, name or "")
    else:
        if platforms:
            raise InputError(
                "platforms are chosen for --target native only; a Python FMU runs where Python runs"
            )
        if version != "2.0":
            raise InputError(f"FMI version {version!r} of target 'python', allowed: '2.0'")
        from .python import friction_files

        files = friction_files(source, interface, name or "")
    files |= friction_documents(source, interface, files, target, version)
    return remember(write_archive(path, files))


def with_diagnosis(source: FrictionSource, file: str | os.PathLike[str]) -> FrictionSource:
    """Return a model with the verdict of a diagnosis, which ``diagnose --json`` wrote to a file, in its card.

    Its note tells where that answer is about none of the tests that the model was trained on, or about another model.
    Raises InputError: the file is no diagnosis.
    """
    from friction_models.discovery.answer.changes import read_diagnosis

    answer = read_diagnosis(Path(file))
    told = {key: answer[key] for key in _TAKEN if key in answer}
    told["file_sha256"] = hashlib.sha256(Path(file).read_bytes()).hexdigest()
    notes = [source.note] if source.note else []
    tests, splits = answer.get("tests"), source.card.get("splits")
    if (
        isinstance(tests, dict)
        and tests
        and isinstance(splits, dict)
        and isinstance(splits.get("train"), list)
    ):
        seen = seen_by_card(source.card, tests)
        told["tests"], told["trained_on"] = len(tests), 0 if seen is None else len(seen.tests)
        if seen is None:
            notes.append(
                f"{file}: this answer is about {counted(len(tests), 'test')}, and the model was trained on none of them as measured there"
            )
    base, name = str(answer.get("model", "")), str(source.card.get("name", "")).replace(" + ", "+")
    # a file may hold this very model
    if base and name and not name.startswith(base) and not Path(base).suffix:
        notes.append(f"{file}: this answer is about the model {base}, and the one that is packed is {name}")
    return replace(source, card=source.card | {"diagnosis": told}, note="\n".join(notes))


def _read(
    model: object,
    spec: str | os.PathLike[str] | None,
    target: str,
    diagnosis: str | os.PathLike[str] | None,
) -> FrictionSource:
    source = read_source(model, spec=spec, target=target)
    return source if diagnosis is None else with_diagnosis(source, diagnosis)


def as_map(source: FrictionSource, **options: Any) -> FrictionSource:
    """Return a friction map, a map as it is; the options are those of `fmus.targets.friction_map.friction_map`.

    Raises InputError: an unknown option, or what cannot become a map.
    """
    if map_axes(source.system) and not options:
        return source
    from ..exports.numbers.table_target import OPTIONS
    from .friction_map import friction_map

    return friction_map(source, **checked_options("map", options, OPTIONS))


def _check_identifier(name: str) -> None:
    if not re.fullmatch(r"[A-Za-z_]\w*", name, flags=re.ASCII) or len(name) > _MAX_NAME:
        near = c_identifier(name)[:_MAX_NAME]
        raise InputError(
            f"name = {name[:80]!r}, allowed: a name as in C of at most {_MAX_NAME} characters, for instance {near!r}"
        )


def _check_names(source: FrictionSource) -> None:
    taken = {q.name for q in LOADS} | {"mu", "domain_distance", "in_domain", "clamp_to_domain", *FMI3_NAMES}
    taken |= {"mu_low", "mu_high"}
    arrays = parameter_arrays(source.system)
    elements = {name for array in arrays for name in array.elements()}
    single = [p.name for p in source.system if p.name not in elements]
    for name in [s.name for s in source.states] + single + [a.name for a in arrays]:
        if name in taken or not re.fullmatch(r"[A-Za-z_]\w*", name, flags=re.ASCII):
            plain = c_identifier(name)
            hint = "" if plain in taken else f", such as {plain!r} for a column of the test table,"
            raise InputError(
                f"{source.where}: state or system variable {name!r} cannot be an FMI variable; "
                f"allowed: a plain name{hint} that is not yet taken ({', '.join(sorted(taken))})"
            )
        taken.add(name)
