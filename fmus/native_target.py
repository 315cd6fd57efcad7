"""Friction FMUs without Python: the model as C, compiled for every wanted platform."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from friction_models.loads import LOADS

from .archive import content_guid
from .interface import FrictionInterface
from .model_description import Description, to_xml
from .source import FrictionSource


def identifier(text: str) -> str:
    """Return `text` as a C identifier."""
    clean = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower() or "model"
    return clean if clean[0].isalpha() else f"m_{clean}"


def friction_description(
    source: FrictionSource, interface: FrictionInterface, target: str, guid: str, sources: Sequence[str] = ()
) -> Description:
    """Return the model description of a friction FMU."""
    native = target == "native"
    common = {
        "needsExecutionTool": not native,
        "canBeInstantiatedOnlyOncePerProcess": False,
        "canNotUseMemoryManagementFunctions": True,
        "canGetAndSetFMUstate": True,
        "canSerializeFMUstate": True,
    }
    if native:
        common["providesDirectionalDerivative"] = True
    co_simulation = {"canHandleVariableCommunicationStepSize": True, "canInterpolateInputs": False} | common
    annotations = {"family": source.family, "target": target, "nodes": str(interface.nodes)}
    for load, (lower, upper) in interface.domain.items():
        annotations[f"domain_{load}"] = f"{lower!r} {upper!r}"
    return Description(
        model_name=f"friction {source.name}",
        identifier=identifier(f"friction_{source.family}"),
        guid=guid,
        text=f"Coefficient of friction from {len(LOADS)} loads: {source.formula or source.name}"[:400],
        variables=interface.variables(),
        co_simulation=co_simulation,
        model_exchange=common if native and not source.states else None,
        sources=sources,
        annotations=annotations,
    )


def native_files(
    source: FrictionSource, interface: FrictionInterface, platforms: Sequence[str] | None
) -> dict[str, bytes]:
    """Return the files of a native friction FMU: description, sources, binaries and the ONNX model."""
    from .native.compile import build, fmi_headers
    from .native.generate import generate

    folder = Path(__file__).parent / "native"
    texts = {n: (folder / n).read_text(encoding="utf-8") for n in ("fmi2.c", "fmi2_more.h", "instance.h")}
    model = generate(source, interface)
    # The GUID covers everything that decides what the FMU computes and shows.
    draft = friction_description(source, interface, "native", "", ["fmi2.c"])
    guid = content_guid(
        {n: t.encode() for n, t in texts.items()}
        | {"model.h": model.encode(), "modelDescription.xml": to_xml(draft), "model.onnx": source.onnx}
    )
    texts["model.h"] = f'#define TF_GUID "{guid}"\n{model}'
    texts |= fmi_headers()
    description = friction_description(source, interface, "native", guid, ["fmi2.c"])
    binaries = build(texts, "fmi2.c", description.identifier, platforms)
    return (
        {"modelDescription.xml": to_xml(description), "resources/model.onnx": source.onnx}
        | {f"sources/{n}": t.encode() for n, t in texts.items()}
        | {f"binaries/{n}": b for n, b in binaries.items()}
    )
