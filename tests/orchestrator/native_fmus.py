"""Small FMI 2.0 co-simulation FMUs in C, compiled on the spot: partners of friction FMUs in tests, for hosts without Python."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fmus.archive.content import write_archive
from fmus.native.compile import build, fmi_headers

_CODE = """
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#include "fmi2Functions.h"

enum { %(names)s, COUNT };
typedef struct { double v[COUNT]; fmi2CallbackLogger logger; void *environment; char name[64]; double reached; } model;
#define V(x) (m->v[x])
#define SAY(...) m->logger(m->environment, m->name, fmi2Error, "logStatusError", __VA_ARGS__)

static void outputs(model *m, double t) { (void)m; (void)t; %(outputs)s }
static int step(model *m, double t, double h) { (void)m; (void)t; (void)h; %(step)s return 1; }
static void start(model *m) { %(start)s outputs(m, 0.0); }

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String where,
                              const fmi2CallbackFunctions *f, fmi2Boolean visible, fmi2Boolean logging) {
    (void)type; (void)guid; (void)where; (void)visible; (void)logging;
    model *m = calloc(1, sizeof *m);
    if (!m) return NULL;
    m->logger = f->logger;
    m->environment = f->componentEnvironment;
    strncpy(m->name, name, sizeof m->name - 1);
    start(m);
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real t, fmi2Boolean d, fmi2Real e) {
    (void)c; (void)a; (void)b; (void)t; (void)d; (void)e; return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { outputs(c, 0.0); return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { start(c); return fmi2OK; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String which[]) {
    (void)c; (void)on; (void)n; (void)which; return fmi2OK; }
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real x[]) {
    for (size_t k = 0; k < n; ++k) x[k] = ((model *)c)->v[vr[k]];
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real x[]) {
    for (size_t k = 0; k < n; ++k) ((model *)c)->v[vr[k]] = x[k];
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean last) {
    (void)last;
    if (!step(c, t, h)) return %(refused)s;
    ((model *)c)->reached = t + h;
    outputs(c, t + h);
    return fmi2OK;
}
#define NONE(call, type) fmi2Status call(fmi2Component c, const fmi2ValueReference vr[], size_t n, type x[]) { \\
    (void)c; (void)vr; (void)x; return n ? fmi2Error : fmi2OK; }
NONE(fmi2GetInteger, fmi2Integer) NONE(fmi2GetBoolean, fmi2Boolean) NONE(fmi2GetString, fmi2String)
NONE(fmi2SetInteger, const fmi2Integer) NONE(fmi2SetBoolean, const fmi2Boolean) NONE(fmi2SetString, const fmi2String)
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) {
    if (!*s) *s = malloc(sizeof(model));
    memcpy(*s, c, sizeof(model));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) { memcpy(c, s, sizeof(model)); return fmi2OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) { (void)c; free(*s); *s = NULL; return fmi2OK; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) { (void)c; (void)s; (void)n; return fmi2Error; }
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) { (void)c; (void)s; (void)b; (void)n; return fmi2Error; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s) { (void)c; (void)b; (void)n; (void)s; return fmi2Error; }
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference u[], size_t nu, const fmi2ValueReference k[],
                                        size_t nk, const fmi2Real dk[], fmi2Real du[]) {
    (void)c; (void)u; (void)nu; (void)k; (void)nk; (void)dk; (void)du; return fmi2Error; }
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer o[], const fmi2Real x[]) {
    (void)c; (void)vr; (void)o; (void)x; return n ? fmi2Error : fmi2OK; }
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer o[], fmi2Real x[]) {
    (void)c; (void)vr; (void)o; (void)x; return n ? fmi2Error : fmi2OK; }
fmi2Status fmi2CancelStep(fmi2Component c) { (void)c; return fmi2Error; }
#define STATUS(call, type) fmi2Status call(fmi2Component c, const fmi2StatusKind k, type *x) { (void)c; (void)k; (void)x; return fmi2Discard; }
STATUS(fmi2GetStatus, fmi2Status) STATUS(fmi2GetIntegerStatus, fmi2Integer) STATUS(fmi2GetStringStatus, fmi2String)
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *x) {
    (void)c; *x = %(terminated)d; return k == fmi2Terminated ? fmi2OK : fmi2Discard; }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *x) {
    *x = ((model *)c)->reached; return k == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard; }
"""

_XML = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{name}" variableNamingConvention="structured">
  <CoSimulation modelIdentifier="{name}" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true"/>
  <UnitDefinitions>{units}</UnitDefinitions>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.01"/>
  <ModelVariables>{variables}</ModelVariables>
  <ModelStructure><Outputs>{outputs}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>
</fmiModelDescription>
"""


#: What units are made of: OMSimulator compares that, not their names.
_BASE = {
    "mm/s": 'm="1" s="-1" factor="0.001"',
    "degC": 'K="1" offset="273.15"',
    "MPa": 'kg="1" m="-1" s="-2" factor="1000000.0"',
    "mm": 'm="1" factor="0.001"',
    "1": "",
}


@dataclass(frozen=True)
class Real:
    """One variable: ``V(name)`` in the C code; an indexed name ``x[3]`` is ``V(x_3)`` there."""

    name: str
    causality: str
    start: float = 0.0
    unit: str = "1"

    @property
    def symbol(self) -> str:
        return self.name.replace("[", "_").rstrip("]")


def native_fmu(
    path: Path,
    variables: Sequence[Real],
    outputs: str = "",
    step: str = "",
    platforms: Sequence[str] = (),
    refused: str = "fmi2Error",
    terminated: bool = False,
) -> Path:
    """Compile an FMU.

    Parameters
    ----------
    path : Path
        The FMU; its stem is the model's name.
    variables : sequence of Real
        Inputs, outputs, parameters and locals.
    outputs : str
        C statements that compute outputs at time ``t``.
    step : str
        C statements that advance the model from ``t`` by ``h``; ``return 0;`` fails.
    refused : str
        Status of such a step.
    terminated : bool
        Whether the FMU answers that it ended the simulation when it is asked after a discarded step.
    """
    name = path.stem
    code = _CODE % {
        "names": ", ".join(v.symbol for v in variables),
        "outputs": outputs,
        "step": step,
        "refused": refused,
        "terminated": terminated,
        "start": " ".join(f"V({v.symbol}) = {v.start!r};" for v in variables),
    }
    lines, given = [], []
    for k, v in enumerate(variables):
        exact = v.causality in {"input", "parameter"}
        start = f' start="{v.start!r}"' if exact else ""
        kind = 'variability="fixed" initial="exact"' if v.causality == "parameter" else ""
        lines.append(
            f'<ScalarVariable name="{v.name}" valueReference="{k}" causality="{v.causality}" {kind}>'
            f'<Real unit="{v.unit}"{start}/></ScalarVariable>'
        )
        if v.causality == "output":
            # Outputs answer the inputs of the step before: no master sees an algebraic loop.
            given.append(f'<Unknown index="{k + 1}" dependencies=""/>')
    xml = _XML.format(
        name=name,
        units="".join(_unit(u) for u in sorted({v.unit for v in variables})),
        variables="".join(lines),
        outputs="".join(given),
        unknowns="".join(given),
    )
    built = build({"model.c": code} | fmi_headers(), "model.c", name, list(platforms) or None)
    files = {"modelDescription.xml": xml.encode()} | {f"binaries/{n}": b for n, b in built.items()}
    return write_archive(path, files)


def _unit(name: str) -> str:
    base = f"<BaseUnit {_BASE[name]}/>" if name in _BASE else ""
    return f'<Unit name="{name}">{base}</Unit>'
