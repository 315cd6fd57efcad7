"""Virtual press: force-stroke curves of forward rod extrusion under the laboratory's true friction law.

The solver runs at another resolution and with another material than a simulation that is compared with
the curves would use; the machine gives way elastically, and every repeat has its own lubricant,
material and sensor noise.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from forming.fre import ForwardRodExtrusion
from forming.material import steel_16MnCr5
from forming.press import PressCurves, PressLevel
from friction_models.loads import FloatArray, InputError

from ..pool import Progress, map_unordered
from ..raw_campaign import RawCampaign
from .campaign import Campaign, load_truth
from .law import ContactLaw, TrueLaw

#: Tool temperature [degC] and punch speed [mm/s] of the levels that are pressed by default.
LEVELS = ((20.0, 5.0), (100.0, 5.0), (20.0, 50.0))


@dataclass(frozen=True)
class VirtualPress:
    """The press and its billets as they really are; standard deviations unless said otherwise.

    Attributes
    ----------
    mesh_size : float
        Elements of the solver run [mm].
    flow_stress : float
        True flow stress over the one in the tables.
    flow_stress_scatter, mu_scatter : float
        From billet to billet.
    compliance : float
        Elastic give of machine and tools that the stroke sensor sees as travel [mm/kN].
    force_noise, stroke_noise : float
        Of the sensors [kN], [mm].
    gain : float
        Of the force cell's amplification, from repeat to repeat.
    T_billet : float
        Billet temperature before the stroke [degC].
    """

    mesh_size: float = 0.35
    flow_stress: float = 1.006
    flow_stress_scatter: float = 0.006
    mu_scatter: float = 0.003
    compliance: float = 8.0e-4
    force_noise: float = 0.6
    stroke_noise: float = 0.002
    gain: float = 0.002
    T_billet: float = 20.0


def press_curves(
    source: Campaign | RawCampaign | TrueLaw | str | os.PathLike[str],
    levels: Sequence[tuple[float, float]] = LEVELS,
    out: str | os.PathLike[str] | None = None,
    *,
    stroke: float = 20.0,
    repeats: int = 5,
    seed: int = 0,
    press: VirtualPress | None = None,
    process: Mapping[str, float] | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> PressCurves:
    """Press every level with the true friction law of a virtual campaign.

    Parameters
    ----------
    source : Campaign, RawCampaign, TrueLaw or path-like
        Where the law is: a campaign, the folder it was written to, or the law itself.
    levels : sequence of (T_tool, speed)
        Tool temperature [degC] and punch speed [mm/s].
    out : path-like, optional
        Folder of press curves to write, labelled synthetic.
    stroke : float
        Punch travel [mm].
    repeats : int
        Curves a level.
    seed : int
        Of scatter and noise.
    press : VirtualPress, optional
        Reality of the press.
    process : mapping, optional
        Other parameters of `forming.ForwardRodExtrusion` (diameter, exit_diameter, half_angle, ...).
    jobs : int, optional
        Processes; all cores by default.
    progress : callable, optional
        Called with (done, total, what).

    Returns
    -------
    PressCurves

    Raises
    ------
    InputError
        No truth there, no levels, or a level that the solver refuses.
    """
    law = _law(source)
    press = press or VirtualPress()
    if not levels:
        raise InputError("press curves: no levels; allowed: at least one pair (T_tool, speed)")
    if not (isinstance(repeats, int) and 1 <= repeats <= 100):
        raise InputError(f"press curves: repeats = {repeats!r}; allowed: 1 to 100")
    report = progress or (lambda done, of, what: None)
    # Scatter enters through two runs: friction changes the force nearly in proportion, within its scatter.
    shifts = (0.0, 2.0 * press.mu_scatter) if repeats > 1 else (0.0,)
    items = [
        (law.to_dict(), float(T), float(speed), shift, float(stroke), press, dict(process or {}))
        for T, speed in levels
        for shift in shifts
    ]
    runs: dict[int, tuple[FloatArray, FloatArray]] = {}
    for index, run in map_unordered(_extrude, items, jobs):
        runs[index] = run
        T, speed = items[index][1], items[index][2]
        report(len(runs), len(items), f"virtual press at {T:g} degC, {speed:g} mm/s")
    records = []
    for k, (T, speed) in enumerate(levels):
        base = runs[len(shifts) * k]
        more = runs[len(shifts) * k + len(shifts) - 1]
        slope = (more[1] - base[1]) / shifts[-1] if len(shifts) > 1 else np.zeros_like(base[1])
        rng = np.random.default_rng([seed, 7004, k])
        curves = pd.concat(
            [_repeat(base, slope, float(speed), r, press, rng) for r in range(1, repeats + 1)],
            ignore_index=True,
        )
        name = f"fre_{speed:g}mms_{T:g}C.csv"
        records.append(PressLevel("fre", float(T), float(speed), "virtual", name, curves, synthetic=True))
    info = {
        "notice": "synthetic: made by the virtual laboratory, not measured",
        "process": dict(process or {}),
        "stroke_mm": float(stroke),
        "T_billet_degC": press.T_billet,
        "repeats": repeats,
        "seed": seed,
    }
    result = PressCurves(tuple(records), info)
    if out is not None:
        result.save(out)
    return result


def _law(source: Campaign | RawCampaign | TrueLaw | str | os.PathLike[str]) -> TrueLaw:
    if isinstance(source, TrueLaw):
        return source
    if isinstance(source, Campaign):
        return source.true_law
    folder = source.folder if isinstance(source, RawCampaign) else source
    return TrueLaw.from_dict(load_truth(folder)[0]["law"])


def _extrude(
    law: dict[str, Any],
    T_tool: float,
    speed: float,
    shift: float,
    stroke: float,
    press: VirtualPress,
    process: dict[str, float],
) -> tuple[FloatArray, FloatArray]:
    """Return stroke [mm] and force [kN] of one solver run with mu shifted."""
    nominal = steel_16MnCr5()
    contact = ContactLaw(TrueLaw.from_dict(law))
    arguments: dict[str, Any] = {"T_billet": press.T_billet, "mesh_size": press.mesh_size, **process}
    solver = ForwardRodExtrusion(
        speed=speed,
        T_tool=T_tool,
        material=replace(nominal, A=nominal.A * press.flow_stress, name="16MnCr5, virtual"),
        **arguments,
    )
    result = solver.run(lambda loads, t: np.maximum(contact(loads, t) + shift, 0.0), stroke=stroke)
    if result.status != "ok":
        raise InputError(f"virtual press at {T_tool:g} degC, {speed:g} mm/s: {result.message}")
    return np.asarray(result.stroke), np.asarray(result.force)


def _repeat(
    base: tuple[FloatArray, FloatArray],
    slope: FloatArray,
    speed: float,
    number: int,
    press: VirtualPress,
    rng: np.random.Generator,
) -> pd.DataFrame:
    """Return one repeat as the sensors record it: 1 kHz, at most about 2000 rows."""
    stroke, force = base
    mu, kf, gain = rng.standard_normal(3)
    force = (force + slope * press.mu_scatter * mu) * (1.0 + press.flow_stress_scatter * kf)
    travel = np.maximum.accumulate(stroke + press.compliance * np.maximum.accumulate(force))
    spacing = max(speed * 1e-3, float(travel[-1]) / 2000.0)
    at = np.arange(0.0, float(travel[-1]), spacing)
    measured = np.interp(at, travel, force) * (1.0 + press.gain * gain)
    measured = measured + press.force_noise * rng.standard_normal(len(at))
    seen = np.maximum.accumulate(at + press.stroke_noise * rng.standard_normal(len(at)))
    return pd.DataFrame(
        {"stroke": np.round(seen, 4), "force": np.round(measured, 3), "repeat": np.full(len(at), number)}
    )
