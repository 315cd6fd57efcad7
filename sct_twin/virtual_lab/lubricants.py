"""Lubricants of the virtual laboratory: base laws that no linear model and no catalogue holds.

Each law is smooth and made of rational and inverse-tangent functions of the five loads and of the friction
work per area; factors are multiplied, so that loads act together. They behave as such films do in published
tests (friction falls with pressure, a polymer softens and then fails with heat, MoS2 lasts longer in heat
and wears with the surface it has to cover), but no formula or number is that of a product.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from friction_models.common import unknown_name
from friction_models.loads import FloatArray

from .hidden_effects import LawInput


@dataclass(frozen=True)
class Lubricant:
    """A base law.

    >>> sorted(LUBRICANTS)
    ['mos2', 'polymer']
    >>> one = np.ones(1)
    >>> load = LawInput(50 * one, 20 * one, 500 * one, 0 * one, one, 0 * one, {})
    >>> polymer = LUBRICANTS["polymer"]
    >>> bool(0.02 < polymer.law(load, polymer.parameters)[0] < 0.1)
    True
    """

    #: What it stands for.
    name: str
    meaning: str
    #: The law in words.
    formula: str
    #: Around which a campaign draws its own.
    parameters: Mapping[str, float]
    #: ``law(loads, parameters) -> mu``.
    law: Callable[[LawInput, Mapping[str, float]], FloatArray]
    #: Friction while the specimen is upset.
    upsetting_mu: float


def _share(x: FloatArray) -> FloatArray:
    """Return x / (1 + x) of what is not negative."""
    positive = np.maximum(x, 0.0)
    return np.asarray(positive / (1.0 + positive))


def _polymer(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    pressed = 1.0 / np.sqrt(1.0 + i.sigma_n / p["s1"])
    soft = 1.0 - p["c_T"] * _share((np.maximum(i.T - 20.0, 0.0) / p["T1"]) ** 1.5)
    quick = 1.0 - p["c_v"] * (2.0 / np.pi) * np.arctan(i.v_rel / p["v1"])
    thinned = 1.0 + p["c_psi"] * _share((i.psi - 1.0) / p["x1"])
    failed = _share((np.maximum(i.T, 0.0) / p["T2"]) ** 6 * (1.0 + i.work / p["W2"]))
    return np.asarray(p["floor"] + p["film"] * pressed * soft * quick * thinned + p["rise"] * failed)


def _mos2(i: LawInput, p: Mapping[str, float]) -> FloatArray:
    pressed = 1.0 - p["c_s"] * _share((i.sigma_n / p["s1"]) ** 2)
    aligned = 1.0 + p["c_0"] / (1.0 + (i.sd / p["d1"]) ** 1.5)
    dried = 1.0 - p["c_T"] * (2.0 / np.pi) * np.arctan(np.maximum(i.T - 20.0, 0.0) / p["T1"])
    worn = _share((i.work / p["W1"]) ** 2 * (0.3 + np.maximum(i.psi - 1.0, 0.0)))
    quick = p["c_v"] * _share(i.v_rel / p["v1"])
    return np.asarray(p["floor"] + p["film"] * pressed * aligned * dried + quick + p["rise"] * worn)


LUBRICANTS: dict[str, Lubricant] = {
    lubricant.name: lubricant
    for lubricant in (
        Lubricant(
            "polymer",
            "a polymer film: softens with heat, carries better at speed, fails when hot and worked",
            "floor + film / sqrt(1 + sigma/s1) (1 - c_T S(((T-20)/T1)^1.5)) (1 - c_v 2/pi atan(v/v1)) "
            "(1 + c_psi S((psi-1)/x1)) + rise S((T/T2)^6 (1 + W/W2)), S(x) = x/(1+x)",
            {
                "floor": 0.022,
                "film": 0.075,
                "s1": 1500.0,
                "c_T": 0.35,
                "T1": 150.0,
                "c_v": 0.25,
                "v1": 60.0,
                "c_psi": 0.25,
                "x1": 0.5,
                "rise": 0.030,
                "T2": 330.0,
                "W2": 4000.0,
            },
            _polymer,
            0.064,
        ),
        Lubricant(
            "mos2",
            "a MoS2 film: little heat dependence, aligns in the first millimetres, wears with work and surface",
            "floor + film (1 - c_s S((sigma/s1)^2)) (1 + c_0/(1 + (sd/d1)^1.5)) (1 - c_T 2/pi atan((T-20)/T1)) "
            "+ c_v S(v/v1) + rise S((W/W1)^2 (0.3 + psi - 1)), S(x) = x/(1+x)",
            {
                "floor": 0.025,
                "film": 0.050,
                "c_s": 0.55,
                "s1": 1600.0,
                "c_0": 0.20,
                "d1": 4.0,
                "c_T": 0.20,
                "T1": 120.0,
                "c_v": 0.006,
                "v1": 150.0,
                "rise": 0.035,
                "W1": 6000.0,
            },
            _mos2,
            0.081,
        ),
    )
}


def lubricant_named(name: str) -> Lubricant:
    """Return a lubricant. Raises InputError: not one of `LUBRICANTS`.

    >>> lubricant_named("mos2").upsetting_mu
    0.081
    """
    if name not in LUBRICANTS:
        raise unknown_name("lubricant", name, LUBRICANTS)
    return LUBRICANTS[name]
