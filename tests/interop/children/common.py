"""What the scripts share: reading the job, writing the result, names to value references."""

from __future__ import annotations

import contextlib
import json
import sys
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path
from typing import Any, TypedDict


class Job(TypedDict, total=False):
    """What a script is to do: one FMU, FMUs by their names, or an SSP; ``series`` has a row of the inputs a step of ``step`` [s].

    Each script reads what it needs. Before the time of ``timed`` steps is taken, it makes ``steps``; ``n`` are contact points.
    """

    fmu: str
    fmus: dict[str, str]
    connections: list[tuple[str, str]]
    ssp: str
    inputs: list[str]
    outputs: list[str]
    series: list[list[float]]
    step: float
    steps: int
    timed: int
    n: int
    description: str
    fmi: str
    validator: str
    folder: str


class Found(TypedDict, total=False):
    """What came out: the outputs, a row a step (of a validator its sentences), and what else was asked for."""

    values: list[Any]
    slopes: list[list[float]]
    times: list[float]
    seconds: float


def job() -> Job:
    """Return the job."""
    with contextlib.suppress(ImportError):  # clients that crash write no core files
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    read: Job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    return read


def done(values: Any, **more: Any) -> None:
    """Write the values of the outputs, a row a step."""
    Path(sys.argv[2]).write_text(json.dumps({"values": values} | more), encoding="utf-8")


def references(fmu: str) -> dict[str, int]:
    """Return value references by name; the FMUs are our own."""
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    found = root.find("ModelVariables")
    assert found is not None
    return {v.attrib["name"]: int(v.attrib["valueReference"]) for v in found}
