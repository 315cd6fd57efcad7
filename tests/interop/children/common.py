"""What the scripts share: reading the job, writing the result, names to value references."""

from __future__ import annotations

import contextlib
import json
import sys
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path
from typing import Any


def job() -> dict[str, Any]:
    """Return the job: ``fmu`` or ``ssp``, ``inputs``, ``outputs`` (names), ``series`` (a row a step), ``step`` [s]."""
    with contextlib.suppress(ImportError):  # clients that crash write no core files
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    read: dict[str, Any] = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
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
