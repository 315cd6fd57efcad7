"""The twin of a single test: from a raw record to a time series of loads and friction."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

import numpy as np
import pandas as pd

from forming.materials.materials import MaterialSource, as_material, steel_16MnCr5
from friction_models.common import InputError
from friction_models.common.ranges import check_flag, check_range

from ..ingest.quality import doubts, quality_row
from ..ingest.raw_campaign import RawCampaign
from ..records.cells import Cell
from ..records.record import SctRecord
from ..signals.filters import smooth
from ..signals.sliding_phase import TestSignals, process
from ..signals.sliding_series import resample
from .contact_reading import ContactReading, measured_diameter
from .heat.sliding import TemperatureHistory, rest, slide
from .heat.thermal_settings import ThermalBody, ThermalSettings
from .test_result import TestResult
from .uncertainty import GivenUncertainty, load_uncertainties
from .upsetting import ContactState, UpsettingCase, fills, geometry, shear_share

#: In the summary of a test: what speaks against its loads, for the remarks of the campaign.
REMARK = "record_remark"


@dataclass
class TwinSettings:
    """Settings of the twin, explained in `SctTwin`, and how a test is evaluated with them.

    Raises InputError: a setting outside its limits.
    """

    material: MaterialSource = field(default_factory=steel_16MnCr5)
    mesh_size: float = 0.7
    thermal: ThermalSettings | None = None
    upsetting_mu: float | None = 0.07
    uniform_pressure: bool = False
    spacing: float = 0.1
    moving_mass: float | None = None
    uncertainty: GivenUncertainty | None = field(default_factory=GivenUncertainty)

    def __post_init__(self) -> None:
        self.material = as_material(self.material)
        self.uniform_pressure = check_flag("SCT twin", "uniform_pressure", self.uniform_pressure)
        limits = {"mesh_size": (0.2, 1.5, "mm"), "spacing": (0.01, 10.0, "mm")}
        if self.upsetting_mu is not None:
            limits["upsetting_mu"] = (0.0, 0.5, "")
        if self.moving_mass is not None:
            limits["moving_mass"] = (0.0, 1e5, "kg")
        for name, (low, high, unit) in limits.items():
            check_range("SCT twin", name, getattr(self, name), low, high, unit)
        for name, kind in (("thermal", ThermalSettings), ("uncertainty", GivenUncertainty)):
            value = getattr(self, name)
            if not (value is None or isinstance(value, kind)):
                raise InputError(f"SCT twin: {name} = {value!r:.60}; allowed: {kind.__name__}, or None")

    @classmethod
    def reference(cls) -> Self:
        """Return a twin of finer mesh and grid, to bound the error of the default one."""
        return cls().finer()

    def finer(self) -> Self:
        """Return this twin with the mesh and the grid of the reference fidelity."""
        grid = replace(self.heat, cells=48, surface_layer=0.025, growth=1.15, depth=16.0)
        return replace(self, mesh_size=0.4, thermal=grid)

    @property
    def heat(self) -> ThermalSettings:
        """Grid and heat data that the sliding phase is computed with."""
        if self.thermal is not None:
            return self.thermal
        return ThermalSettings(specimen=ThermalBody.of(as_material(self.material)))

    def evaluate(self, record: SctRecord, moving_mass: float | None = None) -> TestResult:
        """Evaluate one record.

        Raises InputError: a phase is missing, or the specimen cannot carry the force.

        - `record`: raw channels with metadata: `T_tool` (the plate's temperature where missing),
          `T_specimen`, `bore`, `tip`, ...
        - `moving_mass`: mass between force cell and contact [kg]; the twin's own, or 0, by default.
        """
        mass = next((m for m in (self.moving_mass, moving_mass) if m is not None), 0.0)
        signals = process(record, record.number("moving_mass", mass))
        series = resample(signals, self.spacing)
        T_tool = record.number("T_tool", signals.T_plate)
        mu = self.upsetting_mu
        if mu is None:
            mu = float(np.clip(np.median(series.mu[: max(10, len(series.mu) // 10)]), 0.0, 0.3))
        punch = geometry(record)
        upset_to, seconds = _loading(signals)
        material, T0 = as_material(self.material), record.number("T_specimen", T_tool)
        case = UpsettingCase(punch, upset_to, self.mesh_size, material, mu, T0, T_tool)
        diameter = measured_diameter(record, punch)
        reading = ContactReading(case, seconds, series.F_n, diameter, record.where)
        found = reading.read()
        state = found.upsetting.at(upset_to)
        at_points = reading.at_points(found.upsetting)
        area, psi = at_points.area, at_points.psi
        waiting = _waiting(signals, upset_to)

        def heated(state: ContactState, heat: ThermalSettings) -> TemperatureHistory:
            contact = state.sliding(
                float(series.v_rel.max()), signals.T_plate, T_tool, heat, self.uniform_pressure
            )
            rest(contact, waiting)
            first = np.array([0.0])
            return slide(
                contact,
                np.concatenate([first, series.t]),
                np.concatenate([first, series.sd]),
                np.concatenate([series.friction[:1], series.friction]),
                np.concatenate([series.v_rel[:1], series.v_rel]),
            )

        history = heated(state, self.heat)
        T = history.at(series.sd)
        columns = {
            "t": series.t,
            "v_rel": series.v_rel,
            "T": T["mean"],
            "sigma_n": np.maximum(series.F_n, 0.0) / area,
            "sd": series.sd,
            "psi": psi,
            "mu": series.mu,
            "T_max": T["maximum"],
            "T_plate_surface": T["plate"],
            "T_specimen_surface": T["specimen"],
            "T_film": T["film"],
            "F_n": series.F_n,
            "F_r": series.friction,
            "mu_std": series.mu_std,
        }
        if self.uncertainty is not None:
            columns |= load_uncertainties(
                columns["sigma_n"],
                columns["T"] - signals.T_plate,
                at_points,
                reading.others(found, self.uncertainty),
                state,
                T0,
                self.heat,
                lambda state, heat: heated(state, heat).at(series.sd)["mean"],
                self.uncertainty,
                fills(2.0 * state.radius, punch),
            )
        zero_end = signals.zeros.F_r.after
        summary = {
            "contact_area": round(state.area, 4),
            "upset_height": round(state.height, 4),
            "T_start": round(float(history.mean[0]), 3),
            "sliding": round(float(series.sd[-1]), 3),
            "mu_mean": round(float(series.mu.mean()), 6),
            "sigma_n_mean": round(float(columns["sigma_n"].mean()), 3),
            "psi_mean": round(float(psi.mean()), 5),
            "T_mean": round(float(T["mean"].mean()), 3),
            "v_mean": round(float(series.v_rel.mean()), 4),
            "sigma_n_shear": round(shear_share(state, punch, float(series.mu.mean())), 5),
            "F_n_zero": round(signals.zeros.F_n.before, 3),
            "F_r_zero": round(signals.zeros.F_r.before, 3),
            # only where the record goes on without load: what a zero that is taken before the load does not show
            **({} if zero_end is None else {"F_r_zero_end": round(zero_end, 3)}),
            "mu_noise": float(f"{_mu_noise(signals):.4g}"),
            **found.summary(),
        }
        return TestResult(record.test_id, columns, summary)


def evaluate_file(
    twin: TwinSettings, folder: str, metadata: dict[str, Cell], mass: float
) -> TestResult | str:
    """Evaluate one test of a campaign in a pool; a reason where it cannot be."""
    test_id = str(metadata["test_id"])
    try:
        record = RawCampaign(Path(folder), pd.DataFrame([metadata])).record(test_id)
        # Whoever wrote the folder: what no such test measures, a wrong sign or unit, is refused as `ingest` does.
        doubtful = doubts(quality_row(record, mass))
        result = twin.evaluate(record, mass)
        return replace(result, summary={**result.summary, REMARK: "; ".join(doubtful)})
    except InputError as error:
        return str(error)


def _loading(signals: TestSignals) -> tuple[float, float]:
    """Return the highest normal force before sliding [N], smoothed, and how long it took to get there [s]."""
    span = slice(max(signals.load_start - 1, 0), signals.slide_start)
    dt = float(signals.t[1] - signals.t[0])
    F_n = np.maximum(smooth(signals.F_n, dt, 20.0)[span], 0.0)
    t = signals.t[span]
    # A wobble of the last sample is not a state: the contact belongs to what the highest force stays near to.
    reached = F_n >= 0.97 * F_n.max()
    return float(np.median(F_n[reached])), float(t[np.argmax(reached)] - t[0])


def _waiting(signals: TestSignals, upset_to: float) -> float:
    """Return how long the specimen has lain under nearly its full load before it slides [s]."""
    loaded = signals.F_n[: signals.slide_start] >= 0.95 * upset_to
    start = int(np.argmax(loaded)) if loaded.any() else signals.slide_start - 1
    return float(signals.t[signals.slide_start] - signals.t[start])


def _mu_noise(signals: TestSignals) -> float:
    """Return the noise of mu from sample to sample, from second differences of the raw samples."""
    i = signals.slide_start
    span = slice(i + max(2, (len(signals.t) - i) // 4), None)
    mu = signals.friction[span] / np.maximum(signals.F_n[span], 1.0)
    return float(np.std(np.diff(mu, 2)) / np.sqrt(6.0)) if len(mu) > 4 else 0.0
