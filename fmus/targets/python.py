"""FMUs that run in Python: PythonFMU's library around a slave module with a name of its own."""

from __future__ import annotations

import dataclasses
import json
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from friction_models.common import InputError
from friction_models.loads import LOADS

from ..archive.content import content_guid
from ..interface.description import Description, to_xml
from ..interface.friction_source import FrictionSource
from ..interface.friction_variables import variables2
from ..interface.quantities import FrictionInterface
from ..source.reference_results import stimuli, tried
from ..source.traceability import traceability_files


def friction_files(source: FrictionSource, interface: FrictionInterface, name: str = "") -> dict[str, bytes]:
    """Return the files of a friction FMU that runs ONNX Runtime in the simulator's Python; `name` as of `pack`.

    It runs our graph (`resources/model.onnx`); a user's graph that has no translation is run as it is
    (`resources/original.onnx`), with the loads brought into its units and places.
    """
    from ..pages.presentation import presentation_files
    from .native import friction_description, own_identifier, without_interval

    variables = variables2(interface)
    reals = [v for v in variables if v.type == "Real"]
    # A load that was not measured has no limits (JSON knows no infinity) and cannot be outside, as in the native FMU.
    box = [interface.domain.get(q.name) for q in LOADS]
    config = {
        "nodes": interface.nodes,
        "names": [v.name for v in reals],
        "references": {v.name: v.reference for v in variables if v.type == "Boolean"},
        "load_lower": [q.lower for q in LOADS],
        "load_upper": [q.upper for q in LOADS],
        "load_start": [interface.start(q) for q in LOADS],
        "domain": [[b and b[0] for b in box], [b and b[1] for b in box]],
        "domain_scale": [
            1.0 if b is None else b[1] - b[0] if b[1] > b[0] else max(abs(b[1]), 1.0) for b in box
        ],
        "state_start": [s.start for s in source.states],
        "system_start": [p.start for p in source.system],
    }
    script = (Path(__file__).parents[1] / "slaves" / "friction_slave.py").read_text(encoding="utf-8")
    if interface.interval is None:
        script = without_interval(script)
    if source.foreign is not None:
        config["foreign"] = source.foreign
    resources = {"interface.json": (json.dumps(config) + "\n").encode()}
    if source.onnx:
        tried(source, interface, stimuli(interface, 1))  # no generator has looked at the graph
        resources["model.onnx"] = source.onnx
    if source.original is not None:
        resources["original.onnx"] = source.original
    description = friction_description(source, interface, "python", "", name)
    if not name:
        content = resources | {"script": script.encode(), "modelDescription.xml": to_xml(description)}
        description = dataclasses.replace(
            description, identifier=own_identifier(source, content_guid(content))
        )
    shown = presentation_files(source, "2.0") | traceability_files(source)
    return python_fmu_files(description, script, resources, alone=True) | shown


def python_fmu_files(
    description: Description, script: str, resources: dict[str, bytes], alone: bool = False
) -> dict[str, bytes]:
    """Return a slave script, its resources and PythonFMU as the files of an FMU, by their path in the archive.

    The GUID of the description is filled with a hash of the content. The script has one class whose statement ends in
    ``(Fmi2Slave):``, as PythonFMU looks for it; the name of its module is unique to the content, as all FMUs of a process
    share one interpreter and modules of equal names would collide. `alone`: the FMU carries the Python part of PythonFMU in
    ``resources/fallback``, for interpreters where it is not installed.
    """
    try:
        # Not by import: in a process that runs a Python FMU the name stands for the FMU's own copy.
        package = Path(str(distribution("pythonfmu").locate_file("pythonfmu")))
    except PackageNotFoundError:
        raise InputError(
            "pythonfmu is not installed; allowed: tribofmu installed with its dependencies"
        ) from None
    content = {f"resources/{n}": c for n, c in resources.items()}
    if alone:
        # Not beside the script, where PythonFMU's builder puts it: there it would stand before the installed
        # package, also for the rest of the process, and be gone with the unpacked FMU.
        files = sorted(package.glob("*.py"))
        content |= {f"resources/fallback/pythonfmu/{f.name}": f.read_bytes() for f in files}
    libraries = sorted(
        p for p in (package / "resources" / "binaries").rglob("*") if p.suffix in {".so", ".dll", ".dylib"}
    )
    for library in libraries:
        name = f"binaries/{library.parent.name}/{description.identifier}{library.suffix}"
        content[name] = library.read_bytes()
    guid = content_guid(content | {"script": script.encode(), "modelDescription.xml": to_xml(description)})
    module = f"{description.identifier}_{guid.strip('{}').replace('-', '')}"
    content[f"resources/{module}.py"] = script.encode()
    content["resources/slavemodule.txt"] = module.encode()
    content["modelDescription.xml"] = to_xml(dataclasses.replace(description, guid=guid))
    return content
