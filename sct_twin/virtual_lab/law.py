"""The friction law that holds in the virtual laboratory: a base law, plus hidden effects; and the files of the truth.

No training or diagnosis reads the truth of a campaign.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common import InputError, write_json
from friction_models.common.files import read_json
from friction_models.loads import FloatArray

from .hidden_effects import HIDDEN, HiddenEffect, LawInput, hidden_names
from .lubricants import lubricant_named

#: Constant, and change of mu per mm/s, K, MPa, mm and 1; each test campaign draws its own around these.
BASE = {"constant": 0.0770, "v_rel": -1.0e-5, "T": -2.0e-5, "sigma_n": -4.0e-6, "sd": 6.0e-5, "psi": 3.0e-3}
#: Friction never falls below this.
LEAST_MU = 0.005


@dataclass(frozen=True)
class TrueLaw:
    """Base coefficients and hidden effects with the parameters that were drawn.

    A law with a slope of the pressure only:

    >>> base = {"constant": 0.1, "v_rel": 0.0, "T": 0.0, "sigma_n": -2e-5, "sd": 0.0, "psi": 0.0}
    >>> law = TrueLaw(base)
    >>> one = np.ones(2)
    >>> load = LawInput(50 * one, 20 * one, np.array([0.0, 1000.0]), 0 * one, one, 0 * one, {})
    >>> law.mu(load).round(6).tolist()
    [0.1, 0.08]
    >>> TrueLaw.from_dict(law.to_dict()) == law
    True
    """

    #: Coefficients of the base law: keys as in `BASE`, or the parameters of the lubricant.
    base: Mapping[str, float]
    hidden: tuple[tuple[HiddenEffect, Mapping[str, float]], ...] = field(default=())
    #: Whose law the base is; None: linear in the five loads.
    lubricant: str | None = None

    @classmethod
    def draw(cls, hidden: str | Sequence[str] | None, seed: int, lubricant: str | None = None) -> TrueLaw:
        """Draw the law of a campaign: slopes within 30 %, parameters of lubricants and effects within 10 %."""
        rng = np.random.default_rng([seed, 7001])
        base = {
            name: value * float(rng.uniform(0.95, 1.05) if name == "constant" else rng.uniform(0.7, 1.3))
            for name, value in BASE.items()
        }
        effects = []
        for effect in (HIDDEN[name] for name in hidden_names(hidden)):
            drawn = {name: value * float(rng.uniform(0.9, 1.1)) for name, value in effect.parameters.items()}
            effects.append((effect, drawn))
        if lubricant is not None:
            nominal = lubricant_named(lubricant).parameters
            rng = np.random.default_rng([seed, 7011, *lubricant.encode()])
            base = {name: value * float(rng.uniform(0.9, 1.1)) for name, value in nominal.items()}
        return cls(base, tuple(effects), lubricant)

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> TrueLaw:
        """Rebuild from `to_dict`."""
        effects = tuple(
            (HIDDEN[hidden_names(item["name"])[0]], dict(item["parameters"])) for item in content["hidden"]
        )
        return cls(dict(content["base"]), effects, content.get("lubricant"))

    def to_dict(self) -> dict[str, Any]:
        """Return a description for the truth file."""
        return {
            "lubricant": self.lubricant,
            "base": dict(self.base),
            "hidden": [
                {"name": effect.name, "formula": effect.formula, "parameters": dict(parameters)}
                for effect, parameters in self.hidden
            ],
        }

    def without_hidden(self, i: LawInput) -> FloatArray:
        """Return the base law alone."""
        b = self.base
        if self.lubricant is not None:
            return lubricant_named(self.lubricant).law(i, b)
        return np.asarray(
            b["constant"]
            + b["v_rel"] * i.v_rel
            + b["T"] * i.T
            + b["sigma_n"] * i.sigma_n
            + b["sd"] * i.sd
            + b["psi"] * (i.psi - 1.0)
        )

    def mu(self, i: LawInput) -> FloatArray:
        """Return the coefficient of friction without any scatter."""
        mu = self.without_hidden(i)
        for effect, parameters in self.hidden:
            mu = mu + effect.contribution(i, parameters)
        return np.maximum(mu, LEAST_MU)


class ContactLaw:
    """The true law at contact points over many steps; sums up the friction work of each point.

    Called as ``law(loads, t)`` with loads of shape (n, 5) in the order of the contract; the points must
    keep their order. Work grows with the sliding distance since the last call, once an instant; at time
    zero it starts anew.

    >>> base = {"constant": 0.1, "v_rel": 0.0, "T": 0.0, "sigma_n": -2e-5, "sd": 0.0, "psi": 0.0}
    >>> friction = ContactLaw(TrueLaw(base))
    >>> friction(np.array([[50.0, 20.0, 1000.0, 0.0, 1.0]]), t=0.0).round(6).tolist()
    [0.08]
    """

    def __init__(self, law: TrueLaw) -> None:
        self.law = law
        self._work: FloatArray | None = None
        self._sd: FloatArray | None = None
        self._t = -np.inf

    def __call__(self, loads: FloatArray, t: float) -> FloatArray:
        """Return mu, shape (n,)."""
        v_rel, T, sigma_n, sd, psi = np.asarray(loads, dtype=np.float64).T
        if self._work is None or self._sd is None or len(self._sd) != len(sd) or t <= 0.0:
            self._work, self._sd, self._t = np.zeros(len(sd)), sd.copy(), -np.inf
        if t > self._t:
            mu = self.law.mu(LawInput(v_rel, T, sigma_n, sd, psi, self._work, {}))
            self._work = self._work + mu * sigma_n * np.maximum(sd - self._sd, 0.0)
            self._sd, self._t = sd.copy(), float(t)
        return self.law.mu(LawInput(v_rel, T, sigma_n, sd, psi, self._work, {}))


TRUTH_JSON, TRUTH_NPZ = "truth.json", "truth.npz"


def write_truth(
    source: Path, folder: Path, ids: list[str], about: Mapping[str, object]
) -> dict[str, dict[str, float]]:
    """Gather the truth of single tests in `source` into the two truth files of a campaign folder.

    Returns what each specimen, cell and lubricant film was.
    """
    truth: dict[str, FloatArray] = {}
    scatter: dict[str, dict[str, float]] = {}
    for test_id in ids:
        with np.load(source / f"{test_id}.npz", allow_pickle=False) as stored:
            scatter[test_id] = {n[8:]: float(stored[n]) for n in stored.files if n.startswith("scatter/")}
            truth |= {f"{test_id}/{n}": stored[n] for n in stored.files if not n.startswith("scatter/")}
    np.savez_compressed(folder / TRUTH_NPZ, **truth)  # type: ignore[arg-type]
    write_json(folder / TRUTH_JSON, {"synthetic": True, **about, "tests": scatter})
    return scatter


def load_truth(folder: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, dict[str, FloatArray]]]:
    """Read the truth of a campaign: (law and rig, arrays by test). For checks of the laboratory only.

    Raises
    ------
    InputError
        The folder holds no truth.
    """
    path = Path(folder)
    if not (path / TRUTH_JSON).is_file() or not (path / TRUTH_NPZ).is_file():
        raise InputError(
            f"{path}: no {TRUTH_JSON} and {TRUTH_NPZ}; allowed: a folder the virtual laboratory wrote"
        )
    content = read_json(path / TRUTH_JSON)
    tests: dict[str, dict[str, FloatArray]] = {}
    with np.load(path / TRUTH_NPZ, allow_pickle=False) as stored:
        for key in stored.files:
            test_id, _, name = key.partition("/")
            tests.setdefault(test_id, {})[name] = stored[key]
    return content, tests
