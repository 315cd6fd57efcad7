"""Effects as users meet them: names, fixed parameters, plug-ins."""

from __future__ import annotations

import warnings
from typing import Any, ClassVar

import numpy as np
import pytest

from friction_models import effects
from friction_models.common import InputError
from friction_models.common.imports import plugins
from friction_models.effects import Effect, load_catalogue, make_effect
from friction_models.effects.base import Shape
from friction_models.effects.parameters import Amplitude

CATALOGUE_OF_THE_PLAN = {
    "stribeck", "viscous", "thermal_softening", "thermal_breakdown", "pressure_saturation", "pressure_power",
    "surface_expansion", "running_in", "wear_out", "work_exhaustion", "flash_temperature", "static_peak",
    "rate_state", "batch", "tool_roughness", "sensor_drift", "force_zero", "twin_heating",
    "hersey", "rising_speed", "hot_pressure_breakdown",
}  # fmt: skip


class Squeal(Effect):
    """An effect as a user writes it."""

    name = "squeal"
    title = "squeal"
    equation = "mu += c * sd"
    latex = "c s"
    citation = "none"
    where_it_shows = "everywhere"
    driver = ("sd",)
    amplitudes: ClassVar[tuple[Amplitude, ...]] = (Amplitude("c", "1/mm", "slope", 1, 0.1),)

    def basis(self, x: Any, L: Any, p: Any, memory: Any) -> tuple[Any, ...]:
        return (L.sd,)


class Entry:
    """Stands for an installed entry point."""

    def __init__(self, name: str, target: object) -> None:
        self.name, self.value, self.target = name, f"plugin:{name}", target

    def load(self) -> object:
        if isinstance(self.target, Exception):
            raise self.target
        return self.target


def test_catalogue_holds_the_names_of_the_plan() -> None:
    assert set(effects.CATALOGUE) >= CATALOGUE_OF_THE_PLAN


def test_misspelt_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(InputError, match="did you mean 'stribeck'"):
        make_effect("stribek")
    with pytest.raises(InputError, match="v_s"):
        effects.Stribeck(vs=3.0)
    with pytest.raises(InputError, match=r"v_s = -3.0 mm/s is outside the allowed range"):
        effects.Stribeck(v_s=-3.0)


def test_fixed_parameters_are_not_fitted() -> None:
    free, fixed = effects.Stribeck(), effects.Stribeck(v_s=25.0)
    assert fixed.degrees_of_freedom == free.degrees_of_freedom - 1
    assert fixed.grids({"v_rel": (1.0, 500.0)})["v_s"].tolist() == [25.0]
    assert fixed != free and fixed == effects.Stribeck(v_s=25.0)


def test_an_effect_is_evaluated_at_loads_by_name() -> None:
    both = effects.RateState(v_0=1.0, D_c=2.0, age_0=1.0)
    aged = effects.EffectContext(state={"age": np.array([[2.0 * np.e]])})
    assert both.at(aged, v_rel=[0.9, 9.9]) == pytest.approx(np.array([[0.0, 1.0], [np.log(10.0), 1.0]]))
    with pytest.raises(InputError, match=r"unknown load 'vrel'.*did you mean 'v_rel'"):
        effects.Stribeck().at(vrel=[1.0])


def test_scan_values_follow_the_data_within_bounds() -> None:
    shape = Shape("T_b", "degC", "threshold", 30.0, 600.0, 250.0, follows="T", points=5, log=False)
    assert np.allclose(shape.grid({"T": (100.0, 300.0)}), [100, 150, 200, 250, 300])
    assert shape.grid({"T": (0.0, 5000.0)}).max() == 600.0
    assert shape.grid({"T": (40.0, 40.0)}).size >= 1


def test_plug_ins_are_added_and_broken_ones_named(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = [
        Entry("squeal", Squeal),
        Entry("broken", ImportError("no module named thing")),
        Entry("nothing", 42),
        Entry("second", type("Second", (Squeal,), {"name": "stribeck"})),
    ]
    monkeypatch.setattr(plugins, "entry_points", lambda group: entries)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        catalogue = load_catalogue()
    assert catalogue["squeal"] is Squeal and catalogue["stribeck"] is effects.Stribeck
    text = " ".join(str(w.message) for w in caught)
    assert "'broken'" in text and "no module named thing" in text and "'nothing'" in text and "taken" in text
