"""Friction FMUs without Python: the model as C, compiled for every wanted platform."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from friction_models.loads import LOADS

from ..archive.content import content_guid
from ..interface.description import Description, build_description, c_identifier, to_xml
from ..interface.friction_source import FrictionSource
from ..interface.friction_variables import variables2, variables3
from ..interface.quantities import FrictionInterface
from ..interface.time_constants import fastest_time_constant
from ..pages.presentation import LICENCE, presentation_files
from ..source.reference_results import reference_files
from ..source.traceability import traceability_files

#: The C files written by hand: those of both versions of FMI, and those of one.
_SHARED = ("domain.h", "instance.h", "values.h", "sensitivity.h", "snapshot.h")
_OWN = {"2.0": ("fmi2.c", "fmi2_more.h"), "3.0": ("fmi3.c", "fmi3_more.h", "fmi3_rest.h")}
#: Default experiment [s]: its end, its largest and smallest step.
_STOP, _STEP, _LEAST_STEP = 1.0, 0.01, 1e-4


def family_identifier(source: FrictionSource) -> str:
    """Return the C identifier that all models of a family share."""
    return c_identifier(f"friction_{source.family}")


def own_identifier(source: FrictionSource, guid: str) -> str:
    """Return the `modelIdentifier` of an FMU that was given none.

    It belongs to the content: a program that links the sources of several FMUs tells them apart by it.
    """
    return f"{family_identifier(source)}_{guid.strip('{}').replace('-', '')[:16]}"


def default_step(source: FrictionSource) -> float:
    """Return the step of the default experiment [s]: half the fastest time constant of the memory, or less.

    Solvers with a fixed step take it from there, and explicit ones diverge at steps above twice the time constant.
    """
    fastest = fastest_time_constant(source)
    step = _STEP
    while fastest is not None and step > max(0.5 * fastest, _LEAST_STEP):
        step /= 2.0 if f"{step:e}"[0] != "5" else 2.5
    return float(f"{step:.0e}")


def friction_description(
    source: FrictionSource,
    interface: FrictionInterface,
    target: str,
    guid: str,
    name: str = "",
    sources: Sequence[str] = (),
    fmi: str = "2.0",
    ode: bool = False,
) -> Description:
    """Return the model description of a friction FMU, ``native`` or ``python``.

    `guid` is a GUID or instantiation token, `name` that of the model and the `modelIdentifier` (by default the model's name,
    and `own_identifier`), `sources` the files of `sources/` to be compiled. `ode`: the memory is an ODE and the library
    gives its derivatives; its states are then continuous states. A Python FMU is FMI 2.0.
    """
    native = target == "native"
    both = not source.states or ode
    annotations = {"family": source.family, "target": target, "nodes": str(interface.nodes)}
    for load, (lower, upper) in interface.domain.items():
        annotations[f"domain_{load}"] = f"{lower!r} {upper!r}"
    common, co_simulation, model_exchange = _capabilities(fmi, native)
    return Description(
        model_name=name or f"friction {source.name}",
        identifier=name or (own_identifier(source, guid) if guid else family_identifier(source)),
        guid=guid,
        text=f"Coefficient of friction from {len(LOADS)} loads{source.origin}: {source.formula or source.name}"[
            :400
        ],
        variables=variables3(interface, ode) if fmi == "3.0" else variables2(interface, native and ode),
        co_simulation=common | co_simulation,
        model_exchange=common | model_exchange if native and both else None,
        sources=sources,
        step=default_step(source),
        stop=_STOP,
        annotations=annotations,
        licence=LICENCE,
        event_indicators=int(native and both and bool(interface.domain)),
    )


def _capabilities(fmi: str, native: bool) -> tuple[dict[str, bool], dict[str, bool], dict[str, bool]]:
    """Return the flags of both interfaces, of co-simulation and of model exchange."""
    common = {"needsExecutionTool": not native, "canBeInstantiatedOnlyOncePerProcess": False}
    if fmi == "3.0":
        names = (
            "canGetAndSetFMUState",
            "canSerializeFMUState",
            "providesDirectionalDerivatives",
            "providesAdjointDerivatives",
            "providesPerElementDependencies",
        )
        return (
            common | dict.fromkeys(names, True),
            {"canHandleVariableCommunicationStepSize": True, "hasEventMode": False},
            {"needsCompletedIntegratorStep": True},
        )
    common |= {"canNotUseMemoryManagementFunctions": True, "canGetAndSetFMUstate": True}
    common |= {"canSerializeFMUstate": True}
    if native:
        common["providesDirectionalDerivative"] = True
    return common, {"canHandleVariableCommunicationStepSize": True, "canInterpolateInputs": False}, {}


def without_interval(text: str) -> str:
    """Leave out what only FMUs with a prediction interval need, so that the others carry no dead code.

    In C this stands between ``#if TF_INTERVAL`` and ``#endif /* TF_INTERVAL */`` (what stands behind an ``#else``
    stays), in Python between ``# <interval>`` and ``# </interval>``.
    """
    kept, inside = [], False
    for line in text.splitlines(keepends=True):
        mark = line.strip()
        if mark in {"#if TF_INTERVAL", "# <interval>"}:
            inside = True
        elif mark in {"#endif /* TF_INTERVAL */", "# </interval>"} or (mark == "#else" and inside):
            inside = False
        elif not inside:
            kept.append(line)
    return "".join(kept)


def native_files(
    source: FrictionSource,
    interface: FrictionInterface,
    platforms: Sequence[str] | None,
    fmi: str = "2.0",
    name: str = "",
) -> dict[str, bytes]:
    """Return the files of a native friction FMU by their path in the archive.

    They are description, sources, binaries, ONNX model, icon, terminals, licence and reference results; `platforms` as of
    `native.compile.build`, `name` as of `friction_description`.
    Raises InputError: an operator that is not translated, an unknown platform, no compiler.
    """
    from ..native.compile import build, fmi_headers
    from ..native.generate import generate

    folder = Path(__file__).parents[1] / "native"
    texts = {n: (folder / n).read_text(encoding="utf-8") for n in (*_SHARED, *_OWN[fmi])}
    if interface.interval is None:
        texts = {n: without_interval(text) for n, text in texts.items()}
    main = _OWN[fmi][0]
    model = generate(source, interface)
    ode = "#define TF_ODE 1" in model

    def description(guid: str) -> bytes:
        content = friction_description(source, interface, "native", guid, name, [main], fmi, ode)
        return to_xml(content, fmi, interface.nodes)

    # The GUID covers everything that decides what the FMU computes and shows.
    guid = content_guid(
        {n: t.encode() for n, t in texts.items()}
        | {"model.h": model.encode(), "modelDescription.xml": description(""), "model.onnx": source.onnx}
    )
    texts["model.h"] = f'#define TF_GUID "{guid}"\n{model}'
    own = name or own_identifier(source, guid)
    # The standard keeps its own headers out of `sources/`: who compiles these brings them.
    binaries = build(texts | fmi_headers(fmi), main, own, platforms, fmi)
    files = {"modelDescription.xml": description(guid), "resources/model.onnx": source.onnx}
    if source.original is not None:
        files["resources/original.onnx"] = source.original
    if fmi == "3.0":
        files["sources/buildDescription.xml"] = build_description(own, main)
    return (
        files
        | presentation_files(source, fmi)
        | reference_files(source, interface, fmi)
        | traceability_files(source)
        | {f"sources/{n}": t.encode() for n, t in texts.items()}
        | {f"binaries/{n}": b for n, b in binaries.items()}
    )
