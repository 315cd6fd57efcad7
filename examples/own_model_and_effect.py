"""A friction model and a physical effect of your own: written once, used by fit, ONNX, FMU and diagnosis alike.

``python examples/own_model_and_effect.py`` fits both to made-up points and packs the result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from fmus import check, pack
from friction_models import FrictionModel, TriboLoads
from friction_models.effects import Amplitude, Effect, EffectContext, ShapeParameter
from friction_models.expressions.ops import LoadColumns, Ops, Value


# %% A model: learn in `_fit`, write the law in `formula` against `x`, which computes numbers or draws the graph
class LogSpeed(FrictionModel):
    """mu = mu0 + a ln(1 + v_rel / v0)."""

    family: ClassVar[str] = "log_speed"

    def __init__(self, v0: float = 10.0) -> None:
        self.v0 = v0

    def _fit(self, loads: TriboLoads, mu: np.ndarray, groups: Any) -> None:
        shape = np.log1p(loads.v_rel / self.v0)
        self.a_, self.mu0_ = (float(c) for c in np.polyfit(shape, mu, 1))

    def formula(
        self,
        x: Ops,
        L: LoadColumns,
        S: Sequence[Value] | None = None,
        system: Mapping[str, Value] | None = None,
    ) -> Value:
        return self.mu0_ + self.a_ * x.log(1.0 + L.v_rel / self.v0)

    def formula_text(self) -> str:
        return f"mu = {self.mu0_:.5g} {self.a_:+.4g} ln(1 + v_rel/{self.v0:g})"

    def _learned(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        return {"a": self.a_, "mu0": self.mu0_}, {}

    def _restore(self, values: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        self.a_, self.mu0_ = float(values["a"]), float(values["mu0"])


# %% An effect: amplitudes with their physical sign, shape parameters with bounds, and the basis they multiply
class FilmStarvation(Effect):
    """Friction rises where a long slide meets high pressure: ``delta * (sd sigma_n) / (E + sd sigma_n)``."""

    name = "film_starvation"
    title = "the film starves over distance under pressure"
    equation = "mu += delta * sd sigma_n / (E + sd sigma_n)"
    label = "Film starvation"
    sentence = "friction rises late in tests with high pressure, as the film runs dry"
    latex = r"\mu \mathrel{+}= \delta\,\frac{s\,\sigma_n}{E+s\,\sigma_n}"
    citation = "an example of this documentation"
    where_it_shows = "late in tests with high pressure"
    driver = ("sd", "sigma_n")
    amplitudes = (Amplitude("delta", "1", "friction of the starved film", 1, 0.02),)
    shapes = (ShapeParameter("E", "N/mm", "severity at half starvation", 1e2, 1e6, 2e4),)

    def basis(
        self, x: Ops, L: LoadColumns, p: Mapping[str, Any], context: EffectContext
    ) -> tuple[Value, ...]:
        severity = L.sd * L.sigma_n
        return (severity / (p["E"] + severity),)


# %% An effect that remembers: a state, its rate, and the exact step, by which fits advance all points at once
class FilmForming(Effect):
    """A film that forms over a distance `L` follows the pressure late: ``delta * f``, ``df/dt = v_rel/L (share - f)``."""

    name = "film_forming"
    title = "the film follows the pressure late"
    equation = "mu += delta * f,  df/dt = v_rel/L (sigma_n/(1000 + sigma_n) - f)"
    label = "Film forming"
    sentence = "friction follows changes of the pressure over a distance, as the film forms anew"
    latex = r"\mu \mathrel{+}= \delta f,\quad \dot f=\frac{v_\mathrm{rel}}{L}\left(\frac{\sigma_n}{1000+\sigma_n}-f\right)"
    citation = "an example of this documentation"
    where_it_shows = "after changes of the pressure"
    driver = ("sigma_n", "sd")
    amplitudes = (Amplitude("delta", "1", "friction of the full film", 1, 0.02),)
    shapes = (ShapeParameter("L", "mm", "distance over which the film forms", 0.5, 200.0, 10.0),)
    states = (("film", "1"),)  # name and unit; at the start of a test it is 0, or what `start_state` returns

    def basis(
        self, x: Ops, L: LoadColumns, p: Mapping[str, Any], context: EffectContext
    ) -> tuple[Value, ...]:
        return (context.state["film"],)

    def rate(self, x: Ops, L: LoadColumns, p: Mapping[str, Any], context: EffectContext) -> tuple[Value, ...]:
        return (L.v_rel / p["L"] * (L.sigma_n / (1000.0 + L.sigma_n) - context.state["film"]),)

    def linear_step(
        self, x: Ops, L: LoadColumns, p: Mapping[str, Any], context: EffectContext, dt: Value
    ) -> tuple[Value, ...]:
        keep = x.exp(-L.v_rel * dt / p["L"])  # the step is: film = keep * film + gain
        return (keep, (1.0 - keep) * L.sigma_n / (1000.0 + L.sigma_n))


def made_up_points(seed: int = 0) -> pd.DataFrame:
    """Return made-up (not measured) points of twelve tests that follow both laws, with noise."""
    rng = np.random.default_rng(seed)
    tests = []
    for number in range(12):
        sd = np.linspace(0.0, 50.0, 60)
        v_rel, sigma_n = rng.uniform(5.0, 500.0), rng.uniform(500.0, 2500.0)
        mu = 0.06 - 0.004 * np.log1p(v_rel / 10.0) + 0.03 * sd * sigma_n / (2e4 + sd * sigma_n)
        tests.append(
            pd.DataFrame(
                {
                    "test_id": f"made-up {number}",
                    "t": sd / v_rel,
                    "v_rel": v_rel,
                    "T": 60.0 + sd,
                    "sigma_n": sigma_n,
                    "sd": sd,
                    "psi": 1.1,
                    "mu": mu + rng.normal(0.0, 5e-4, sd.size),
                }
            )
        )
    return pd.concat(tests, ignore_index=True)


def main(folder: Path) -> tuple[FrictionModel, FrictionModel, Path]:
    """Fit the model with and without the effect; return both and the packed FMU."""
    # %% Composition, fit, FMU
    points = made_up_points()
    plain = LogSpeed().fit_frame(points)
    composed = (LogSpeed() + FilmStarvation(E=2e4)).fit_frame(points)
    for name, model in (("plain", plain), ("with effect", composed)):
        error = np.abs(model.predict_frame(points) - points["mu"]).mean()
        print(f"{name}: mean absolute error {error:.5f}; {model.formula_text()}")
    fmu = pack(composed, folder / "composed.fmu")
    print(check(fmu))
    return plain, composed, fmu


# %%
if __name__ == "__main__":
    print("basis at one point:", FilmStarvation(E=2e4).at(sigma_n=1000.0, sd=10.0))
    main(Path("build/own"))
