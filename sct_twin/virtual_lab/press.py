"""Virtual press: force-stroke curves of forming processes under the laboratory's true friction law.

The solver runs at another resolution, with another material and other heat transfer than a simulation that is
compared with the curves would use; the machine gives way elastically, and every repeat has its own lubricant
film, billet and sensor noise.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, cast

import numpy as np
import pandas as pd

from forming.press import PressCurves, PressLevel
from forming.processes.backward_cup_extrusion import BackwardCupExtrusion
from forming.processes.forward_rod_extrusion import ForwardRodExtrusion
from friction_models.common import InputError, unknown_name
from friction_models.common.processes.pool import Progress, map_unordered
from friction_models.loads import FloatArray

from ..ingest.raw_campaign import RawCampaign
from .campaign import Campaign
from .law import ContactLaw, TrueLaw, load_truth
from .rig.specimen import virtual_steel

#: Tool temperature [degC] and punch speed [mm/s] of the levels that are pressed by default.
LEVELS = ((20.0, 5.0), (100.0, 5.0), (20.0, 50.0))
#: Three tool temperatures by three speeds.
NINE_LEVELS = tuple((T, speed) for T in (20.0, 50.0, 100.0) for speed in (5.0, 50.0, 100.0))
#: Punch travel where none is given [mm].
STROKES = {"fre": 20.0, "bce": 12.0}
_SOLVERS: dict[str, type[ForwardRodExtrusion] | type[BackwardCupExtrusion]] = {
    "fre": ForwardRodExtrusion,
    "bce": BackwardCupExtrusion,
}

Source = Campaign | RawCampaign | TrueLaw | str | os.PathLike[str]


@dataclass(frozen=True)
class VirtualPress:
    """The press and its billets as they really are; standard deviations unless said otherwise."""

    #: Elements of the solver runs of forward and of backward extrusion [mm].
    mesh_size: float = 0.35
    cup_mesh_size: float = 0.30
    #: True flow stress and strain hardening exponent over the ones in the tables.
    flow_stress: float = 1.006
    flow_exponent: float = 1.005
    #: True heat transfer coefficient between billet and tools [kW/(m2 K)].
    htc: float = 33.0
    #: From billet to billet.
    flow_stress_scatter: float = 0.006
    mu_scatter: float = 0.003
    #: Elastic give of machine and tools that the stroke sensor sees as travel [mm/kN], and its relative
    #: scatter.
    compliance: float = 8.0e-4
    compliance_scatter: float = 0.05
    #: Of the sensors [kN], [mm].
    force_noise: float = 0.6
    stroke_noise: float = 0.002
    #: Of the force cell's amplification, and of its zero [kN], from repeat to repeat.
    gain: float = 0.002
    zero: float = 0.3
    #: Billet temperature before the stroke [degC].
    T_billet: float = 20.0


def press_curves(
    source: Source | Sequence[Source],
    levels: Sequence[tuple[float, float]] = LEVELS,
    out: str | os.PathLike[str] | None = None,
    *,
    processes: Sequence[str] = ("fre",),
    stroke: float | None = None,
    repeats: int = 5,
    seed: int = 0,
    press: VirtualPress | None = None,
    process: Mapping[str, float] | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> PressCurves:
    """Press every level with the true friction law of one or several virtual campaigns.

    Parameters
    ----------
    source : Campaign, RawCampaign, TrueLaw or path-like, or a sequence of them
        Where the law is: a campaign, the folder it was written to, or the law itself; one for each lubricant.
    levels : sequence of (T_tool, speed)
        Tool temperature [degC] and punch speed [mm/s]; `NINE_LEVELS` for three by three.
    out : path-like, optional
        Folder of press curves to write, labelled synthetic.
    processes : sequence of str
        ``"fre"``, ``"bce"`` or both.
    stroke : float, optional
        Punch travel [mm]; `STROKES` by default.
    repeats : int
        Curves a level.
    seed : int
        Of scatter and noise.
    press : VirtualPress, optional
        Reality of the press.
    process : mapping, optional
        Other parameters of the processes (diameter, billet_length, ...).
    jobs : int, optional
        Processes; all cores by default.
    progress : callable, optional
        Called with (done, total, what).


    Raises
    ------
    InputError
        No truth there, no levels, an unknown process, or a level that the solver refuses.
    """
    one = isinstance(source, Campaign | RawCampaign | TrueLaw | str | os.PathLike)
    sources = cast("list[Source]", [source] if one else list(cast("Sequence[Source]", source)))
    laws = [_law(each) for each in sources]
    press = press or VirtualPress()
    if not levels:
        raise InputError("press curves: no levels; allowed: at least one pair (T_tool, speed)")
    if not (isinstance(repeats, int) and 1 <= repeats <= 100):
        raise InputError(f"press curves: repeats = {repeats!r}; allowed: 1 to 100")
    for kind in processes:
        if kind not in _SOLVERS:
            raise unknown_name("process", kind, _SOLVERS, "press curves")
    names = [law.lubricant or "virtual" for law in laws]
    if len(set(names)) != len(names):
        raise InputError(f"press curves: lubricants {', '.join(names)}; allowed: each of them once")
    report = progress or (lambda done, of, what: None)
    # Scatter enters through two runs: friction changes the force nearly in proportion, within its scatter.
    shifts = (0.0, 2.0 * press.mu_scatter) if repeats > 1 else (0.0,)
    cases = [(law, kind, float(T), float(speed)) for law in laws for kind in processes for T, speed in levels]
    strokes = {kind: STROKES[kind] if stroke is None else float(stroke) for kind in processes}
    items = [(*case, shift, strokes[case[1]]) for case in cases for shift in shifts]
    runs: dict[int, tuple[FloatArray, FloatArray]] = {}
    form = partial(_form, press=press, process=dict(process or {}))
    for index, run in map_unordered(form, items, jobs):
        runs[index] = run
        _, kind, T, speed, *_ = items[index]
        where = "" if len(processes) == 1 else f", {kind}"
        report(len(runs), len(items), f"virtual press at {T:g} degC, {speed:g} mm/s{where}")
    records = []
    for k, (law, kind, T, speed) in enumerate(cases):
        base = runs[len(shifts) * k]
        more = runs[len(shifts) * k + len(shifts) - 1]
        slope = (more[1] - base[1]) / shifts[-1] if len(shifts) > 1 else np.zeros_like(base[1])
        rng, others = np.random.default_rng([seed, 7004, k]), np.random.default_rng([seed, 7017, k])
        curves = pd.concat(
            [_repeat(base, slope, speed, r, press, rng, others) for r in range(1, repeats + 1)],
            ignore_index=True,
        )
        label = "" if law.lubricant is None else f"_{law.lubricant}"
        file = f"{kind}{label}_{speed:g}mms_{T:g}C.csv"
        lubricant = law.lubricant or "virtual"
        records.append(PressLevel(kind, T, speed, lubricant, file, curves, synthetic=True))
    info = {
        "notice": "synthetic: made by the virtual laboratory, not measured",
        "process": dict(process or {}),
        "stroke_mm": strokes,
        "T_billet_degC": press.T_billet,
        "repeats": repeats,
        "seed": seed,
        "reality": asdict(press),
    }
    result = PressCurves(tuple(records), info)
    if out is not None:
        result.save(out)
    return result


def _law(source: Source) -> TrueLaw:
    if isinstance(source, TrueLaw):
        return source
    if isinstance(source, Campaign):
        return source.true_law
    folder = source.folder if isinstance(source, RawCampaign) else source
    return TrueLaw.from_dict(load_truth(folder)[0]["law"])


def _form(
    law: TrueLaw,
    kind: str,
    T_tool: float,
    speed: float,
    shift: float,
    stroke: float,
    press: VirtualPress,
    process: dict[str, float],
) -> tuple[FloatArray, FloatArray]:
    """Return stroke [mm] and force [kN] of one solver run with mu shifted."""
    contact = ContactLaw(law)
    mesh_size = press.mesh_size if kind == "fre" else press.cup_mesh_size
    numbers = {"T_billet": press.T_billet, "mesh_size": mesh_size, "htc": press.htc} | process
    material = virtual_steel(press.flow_stress, press.flow_exponent)
    solver: Any = _SOLVERS[kind]
    solver = solver(speed=speed, T_tool=T_tool, material=material, **numbers)
    result = solver.run(lambda loads, t: np.maximum(contact(loads, t) + shift, 0.0), stroke=stroke)
    if result.status != "ok":
        raise InputError(f"virtual press ({kind}) at {T_tool:g} degC, {speed:g} mm/s: {result.message}")
    return np.asarray(result.stroke), np.asarray(result.force)


def _repeat(
    base: tuple[FloatArray, FloatArray],
    slope: FloatArray,
    speed: float,
    number: int,
    press: VirtualPress,
    rng: np.random.Generator,
    others: np.random.Generator,
) -> pd.DataFrame:
    """Return one repeat as the sensors record it: 1 kHz, at most about 2000 rows."""
    stroke, force = base
    mu, kf, gain = rng.standard_normal(3)
    force = (force + slope * press.mu_scatter * mu) * (1.0 + press.flow_stress_scatter * kf)
    give, zero = others.standard_normal(2)
    compliance = press.compliance * (1.0 + press.compliance_scatter * give)
    travel = np.maximum.accumulate(stroke + compliance * np.maximum.accumulate(force))
    spacing = max(speed * 1e-3, float(travel[-1]) / 2000.0)
    at = np.arange(0.0, float(travel[-1]), spacing)
    measured = np.interp(at, travel, force) * (1.0 + press.gain * gain)
    measured = measured + press.zero * zero + press.force_noise * rng.standard_normal(len(at))
    seen = np.maximum.accumulate(at + press.stroke_noise * rng.standard_normal(len(at)))
    return pd.DataFrame(
        {"stroke": np.round(seen, 4), "force": np.round(measured, 3), "repeat": np.full(len(at), number)}
    )
