"""Trial of `check`: model exchange, simulated by fmpy."""

from __future__ import annotations

import numpy as np

from friction_models.common import InputError
from friction_models.common.wording import counted
from friction_models.loads import LOADS, MU, FloatArray

from ..runtime.fmu_files import UnpackedFmu
from ..runtime.running import RunningFmu
from .report import Notes
from .trial_friction import inside, packed_model

#: Time of the run [s], and the steps that co-simulation makes of it.
_TIME, _STEPS = 0.1, 100


def exchange(fmu: UnpackedFmu, notes: Notes) -> None:
    """Simulate the FMU with fmpy's solver; mu of a friction FMU is compared with co-simulation."""
    if fmu.raw.modelExchange is None:
        notes.note("skipped", "not offered")
        return
    from fmpy import simulate_fmu

    is_friction = fmu.is_friction
    if is_friction:
        _memory(fmu, notes)
        fmu.contact_points()
    outputs = [v for v in fmu.variables.values() if v.causality == "output" and v.is_float64]
    recorded = list(dict.fromkeys(v.own for v in (fmu.arrays[MU.name] if is_friction else outputs)))
    start = _start(fmu) if is_friction else {}
    try:
        result = simulate_fmu(
            str(fmu.folder),
            validate=False,
            fmi_type="ModelExchange",
            stop_time=_TIME,
            output_interval=_TIME / 10,
            start_values={n: " ".join(map(repr, np.ravel(v).tolist())) for n, v in start.items()},
            output=recorded,
            logger=lambda *_: None,
        )
    except Exception as error:  # fmpy raises plain exceptions
        notes.add(False, f"simulated by fmpy: {' '.join(str(error).split())[:300]}")
        return
    finite = all(np.isfinite(result[n]).all() for n in recorded)
    notes.add(
        finite and len(result) > 1,
        f"simulated by fmpy over {_TIME} s, {counted(len(recorded), 'output')}: all values finite",
    )
    if not is_friction:
        return
    if fmu.raw.coSimulation is None:
        _reference(fmu, start, np.concatenate([np.ravel(result[n][0]) for n in recorded]), notes)
        return
    with RunningFmu(fmu, "stepped", start=start) as stepped:
        mine = [stepped.get_real(recorded)]
        for k in range(_STEPS):
            stepped.step(_TIME * k / _STEPS, _TIME / _STEPS)
        mine.append(stepped.get_real(recorded))
    theirs = [np.concatenate([np.ravel(result[n][k]) for n in recorded]) for k in (0, -1)]
    first, last = (float(np.abs(a - b).max()) for a, b in zip(mine, theirs, strict=True))
    # Steps of the memory need not be exact, and the solver has its tolerance.
    notes.add(
        first <= 1e-12 and last <= 1e-4,
        f"mu is that of co-simulation: differences {first:.1e} at the start, {last:.1e} at the end",
    )


def _memory(fmu: UnpackedFmu, notes: Notes) -> None:
    """Tell how fast the memory is, as far as the packed model says so."""
    from ..interface.friction_source import parse_source
    from ..interface.time_constants import fastest_time_constant, hint

    packed = fmu.folder / "resources" / "model.onnx"
    if not packed.is_file():
        return
    try:
        fastest = fastest_time_constant(parse_source(packed.read_bytes(), "resources/model.onnx"))
    except InputError:  # the friction trial has said so
        return
    if fastest is not None:
        notes.note("noted", hint(fastest))


def _reference(fmu: UnpackedFmu, start: dict[str, float | list[float]], mu: FloatArray, notes: Notes) -> None:
    """Compare mu at the start with ONNX Runtime, where there is no co-simulation to do so at many points."""
    model = packed_model(fmu, notes)
    if model is None:
        return
    names = [dict.fromkeys(v.own for v in fmu.arrays[q.name]) for q in LOADS]
    loads = np.array([np.concatenate([np.ravel(start[n]) for n in own]) for own in names]).T
    worst = float(np.abs(mu - model.predict(inside(model, loads))).max())
    notes.add(worst <= 1e-9, f"mu against ONNX Runtime at the start: difference {worst:.1e}")


def _start(fmu: UnpackedFmu) -> dict[str, float | list[float]]:
    """Return loads a little apart from the start values, in the same place of every importer's table."""
    return {
        v.own: [1.01 * x for x in v.starts] if v.base else 1.01 * v.starts[0]
        for q in LOADS
        for v in fmu.arrays[q.name]
    }
