"""Where a system comes from, as metadata inside its archive after SSP Traceability 1.0-rc.2 (a release candidate).

At the places that the specification names: a file about the task (STMD) with the FMUs, their digests and the system that was put together
from them, and a file about the archive as a whole (SRMD). The same content gives the same bytes: the GUID is a hash of it, and the time is that of
the variable ``SOURCE_DATE_EPOCH`` and is left out without it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping

from lxml import etree

from ..archive.content import content_guid, xml_bytes
from ..source.traceability import PATH as RESOURCE_PATH
from ..source.traceability import SRMD, STC, about, classify, text_of, words_of
from .systems import DESCRIPTION, Structure

TASK_PATH = "extra/org.ssp-standard.ssp-traceability.stmd/SimulationTask.stmd"
STMD = "http://ssp-standard.org/SSPTraceability1/SimulationTaskMetaData"
#: Whose words the keywords are.
SYSTEM_KIND, FMU_KIND = "org.tribofmu.system", "org.tribofmu.fmu"
#: From the file about the task to the root of the archive.
_UP = "../../"


def traceability_files(
    structure: Structure, files: Mapping[str, bytes], descriptions: Mapping[str, etree._Element]
) -> dict[str, bytes]:
    """Return the metadata by their path in the archive, whose other files and model descriptions are given by theirs.

    Raises InputError: ``SOURCE_DATE_EPOCH`` is no number of seconds.
    """
    provenance = structure.notes.get("provenance")
    author = str(provenance.get("author") or "") if isinstance(provenance, Mapping) else ""
    head = about(structure.name, author)
    resource = etree.Element(f"{{{SRMD}}}SimulationResourceMetaData", head, nsmap={"srmd": SRMD, "stc": STC})
    classify(resource, SYSTEM_KIND, _facts(structure, files))
    task = etree.Element(
        f"{{{STMD}}}SimulationTaskMetaData",
        head | {"GUID": content_guid(files)},
        nsmap={"stmd": STMD, "stc": STC},
    )
    phase = etree.SubElement(task, f"{{{STMD}}}ImplementationPhase")
    models = _output(phase, "ImplementModel")
    for path, description in sorted(descriptions.items()):
        found = _resource(models, path, "model", "component", "application/x-fmu-sharedlibrary")
        classify(found, FMU_KIND, _fmu_facts(path, files[path], description, structure))
    system = _output(phase, "IntegrateSimulation")
    found = _resource(system, DESCRIPTION, "system", "system", "application/x-ssp-definition")
    classify(found, SYSTEM_KIND, [("sha256", hashlib.sha256(files[DESCRIPTION]).hexdigest())])
    return {RESOURCE_PATH: xml_bytes(resource), TASK_PATH: xml_bytes(task)}


def _output(phase: etree._Element, step: str) -> etree._Element:
    return etree.SubElement(etree.SubElement(phase, f"{{{STMD}}}{step}"), f"{{{STC}}}Output")


def _resource(place: etree._Element, path: str, kind: str, scope: str, mime: str) -> etree._Element:
    return etree.SubElement(
        place, f"{{{STC}}}Resource", {"kind": kind, "scope": scope, "type": mime, "source": f"{_UP}{path}"}
    )


def _facts(structure: Structure, files: Mapping[str, bytes]) -> Iterator[tuple[str, str]]:
    """Yield keyword and value of what is known of the system as a whole."""
    for key in ("stop", "step"):
        if (value := getattr(structure, key)) is not None:
            yield f"experiment.{key}", text_of(value)
    for key, value in structure.notes.items():
        if isinstance(value, Mapping):
            for name, entry in value.items():
                yield f"{key}.{name}", text_of(entry)
        else:
            yield key, words_of(value)
    for path in sorted(files):
        yield f"sha256.{path}", hashlib.sha256(files[path]).hexdigest()


def _fmu_facts(
    path: str, content: bytes, description: etree._Element, structure: Structure
) -> Iterator[tuple[str, str]]:
    """Yield keyword and value of what an FMU says of itself, and of its place in the system."""
    yield "sha256", hashlib.sha256(content).hexdigest()
    yield "components", " ".join(c.name for c in structure.components if c.source == path)
    for key in ("modelName", "fmiVersion", "guid", "instantiationToken", "generationTool", "author"):
        if value := description.get(key):
            yield key, text_of(value)
