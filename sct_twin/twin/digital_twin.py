"""The digital twin of the sliding compression test: from raw records to time series of loads and friction."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from forming.materials.materials import MaterialSource, as_material, steel_16MnCr5
from friction_models.common import InputError, check_folder, grown
from friction_models.common.folders import TWIN
from friction_models.common.pool import Progress, map_unordered

from ..ingest.raw_campaign import RawCampaign
from ..records.record import SctRecord
from ..signals.filters import smooth
from ..signals.sliding_phase import TestSignals, process, resample
from .campaign_result import AVERAGES, KIND, TwinResult
from .contact_diameter import measured_diameter, read_at_diameter
from .sliding import rest, slide
from .test_result import ASSUMPTIONS, EXTRA_UNITS, TestResult, fingerprint, read_netcdf, write_netcdf
from .thermal_settings import ThermalBody, ThermalSettings
from .upsetting import Upsetting, contact_forces, geometry, shear_share, upset_specimen

#: Changes when the same inputs give other results.
TWIN_VERSION = 3


@dataclass
class SctTwin:
    """Digital twin of the sliding compression test.

    Parameters
    ----------
    material : Material, name or path, optional
        Workpiece; 16MnCr5 by default.
    mesh_size : float
        Elements of the upsetting run [mm].
    thermal : ThermalSettings, optional
        Grid and heat data of the sliding phase; by default the specimen's are those of `material`.
    upsetting_mu : float or None
        Friction while upsetting, which no sensor sees; None: that of the first tenth of the sliding.
    uniform_pressure : bool
        Heat the contact evenly instead of by the pressure at the end of upsetting (to see what that is worth).
    spacing : float
        Distance between points [mm].
    moving_mass : float, optional
        Mass between force cell and contact [kg]; the campaign's own by default, unless a column
        `moving_mass` of the test table names one for a test.

    Raises
    ------
    InputError
        A setting outside its limits.

    Notes
    -----
    A test is evaluated in two phases. Upsetting: the FE kernel, driven by the measured normal force,
    gives contact area, pressure and surface expansion. Sliding: the 3-D thermal model, driven by the
    measured speed, normal force and friction, gives the contact temperature. What is assumed stands
    in `sct_twin.twin.test_result.ASSUMPTIONS` and in every file.
    """

    material: MaterialSource = field(default_factory=steel_16MnCr5)
    mesh_size: float = 0.7
    thermal: ThermalSettings | None = None
    upsetting_mu: float | None = 0.07
    uniform_pressure: bool = False
    spacing: float = 0.1
    moving_mass: float | None = None

    def __post_init__(self) -> None:
        limits = {"mesh_size": (0.2, 1.5, "mm"), "spacing": (0.01, 10.0, "mm")}
        if self.upsetting_mu is not None:
            limits["upsetting_mu"] = (0.0, 0.5, "")
        if self.moving_mass is not None:
            limits["moving_mass"] = (0.0, 1e5, "kg")
        for name, (low, high, unit) in limits.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(
                    f"SCT twin: {name} = {value!r}; allowed: {low:g} to {high:g} {unit}".rstrip()
                )

    @classmethod
    def reference(cls) -> SctTwin:
        """Return a twin of finer mesh and grid, to bound the error of the default one."""
        return cls().finer()

    def finer(self) -> SctTwin:
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

        Parameters
        ----------
        record : SctRecord
            Raw channels with metadata: `T_tool` (the plate's temperature where missing), `T_specimen`,
            `bore`, `tip`, ...
        moving_mass : float, optional
            Mass between force cell and contact [kg]; the twin's own, or 0, by default.

        Raises
        ------
        InputError
            A phase is missing, or the specimen cannot carry the force.
        """
        where = record.source or f"test {record.test_id}"
        mass = next((m for m in (self.moving_mass, moving_mass) if m is not None), 0.0)
        signals = process(record, record.number("moving_mass", mass))
        series = resample(signals, self.spacing)
        T_tool = record.number("T_tool", signals.T_plate)
        t, F_n = _loading(signals)
        upset_to = float(F_n[-1])
        mu = self.upsetting_mu
        if mu is None:
            mu = float(np.clip(np.median(series.mu[: max(10, len(series.mu) // 10)]), 0.0, 0.3))
        punch = geometry(record)
        diameter = measured_diameter(record, punch)
        highest = float(series.F_n.max())

        def run_to(force: float) -> Upsetting:
            return upset_specimen(
                punch,
                t,
                F_n,
                max(force, highest),
                as_material(self.material),
                mu,
                record.number("T_specimen", T_tool),
                T_tool,
                self.mesh_size,
                where,
            )

        if diameter is None:
            upsetting, measured = run_to(highest), {}
        else:
            found = read_at_diameter(run_to, float(contact_forces(series.F_n, upset_to)[-1]), diameter, punch)
            upsetting, measured = found.upsetting, found.summary()
        state = upsetting.at(upset_to)
        area, psi = upsetting.area_and_psi(series.F_n, upset_to)
        contact = state.sliding(
            float(series.v_rel.max()), signals.T_plate, T_tool, self.heat, self.uniform_pressure
        )
        rest(contact, _waiting(signals, upset_to))
        first = np.array([0.0])
        history = slide(
            contact,
            np.concatenate([first, series.t]),
            np.concatenate([first, series.sd]),
            np.concatenate([series.friction[:1], series.friction]),
            np.concatenate([series.v_rel[:1], series.v_rel]),
        )
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
            "F_n": series.F_n,
            "F_r": series.friction,
            "mu_std": series.mu_std,
        }
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
            "F_n_zero": round(signals.force_zero[0], 3),
            "F_r_zero": round(signals.force_zero[1], 3),
            # only where the record goes on without load: what a zero that is taken before the load does not show
            **({} if zero_end is None else {"F_r_zero_end": round(zero_end, 3)}),
            "mu_noise": float(f"{_mu_noise(signals):.4g}"),
            **measured,
        }
        return TestResult(record.test_id, columns, summary)

    def run(
        self,
        campaign: RawCampaign | str | os.PathLike[str],
        out: str | os.PathLike[str] | None = None,
        jobs: int | None = None,
        progress: Progress | None = None,
        check: int = 0,
    ) -> TwinResult:
        """Evaluate all tests of a campaign.

        Parameters
        ----------
        campaign : RawCampaign or path-like
            Raw records (`raw/`, `tests.csv`, `campaign.json`).
        out : path-like, optional
            Folder for the data set, with one netCDF file a test under `twin/`. Tests that are there
            already, from the same record and the same settings, are not computed again.
        jobs : int, optional
            Processes; all cores by default.
        progress : callable, optional
            Called with (done, total, what).
        check : int
            So many tests are also evaluated at the reference fidelity and with other assumptions, one at a
            time (`sct_twin.twin.error_study`); the differences go into the result. 0: none.

        Returns
        -------
        TwinResult
            Tests that cannot be evaluated are left out with a reason.

        Raises
        ------
        InputError
            Not a campaign, or none of its tests can be evaluated; `out` holds something else.
        """
        if check < 0:
            raise InputError(f"check = {check} tests; allowed: 0 or more")
        if out is not None:
            check_folder(out, TWIN)
        source = campaign if isinstance(campaign, RawCampaign) else RawCampaign.load(campaign)
        mass = source.moving_mass
        folder = None if out is None else Path(out)
        report = progress or (lambda done, total, what: None)
        ids = [str(test_id) for test_id in source.tests["test_id"]]
        prints = {test_id: self._fingerprint(source, test_id, mass) for test_id in ids}
        attributes = {"synthetic": str(source.synthetic).lower(), "source": "SCT twin"}
        if source.synthetic:
            attributes["notice"] = "synthetic: made by the virtual laboratory, not measured"
        results: dict[str, TestResult] = {}
        failures: dict[str, str] = {}
        if folder is not None:
            (grown(folder, TWIN) / "twin").mkdir(exist_ok=True)
            _sweep(folder)
            for test_id in ids:
                known = read_netcdf(folder / "twin" / f"{test_id}.nc")
                if known is not None and known.summary.get("fingerprint") == prints[test_id]:
                    results[test_id] = known
        if results:
            report(len(results), len(ids), f"{len(results)} tests known")
        open_ids = [test_id for test_id in ids if test_id not in results]
        items = [(self, str(source.folder), source.metadata(test_id), mass) for test_id in open_ids]
        for index, outcome in map_unordered(evaluate_file, items, jobs):
            test_id = open_ids[index]
            if isinstance(outcome, str):
                failures[test_id] = outcome
            else:
                summary = {**outcome.summary, "fingerprint": prints[test_id]}
                results[test_id] = TestResult(test_id, outcome.columns, summary)
                if folder is not None:
                    write_netcdf(results[test_id], folder / "twin" / f"{test_id}.nc", attributes)
            report(len(results) + len(failures), len(ids), f"twin of test {test_id}")
        if not results:
            raise InputError(f"none of {len(ids)} tests can be evaluated; the first: {failures[ids[0]]}")
        result = self._assemble(source, ids, results, failures)
        if check:
            from . import error_study as twin_error

            done = [test_id for test_id in ids if test_id in results]
            result.errors = twin_error.check(self, source, done, check, jobs, progress)
            result.info["errors"] = {"unit": "%", "largest": twin_error.summary(result.errors)}
        if folder is not None:
            result.save(folder)
        return result

    def _assemble(
        self,
        source: RawCampaign,
        ids: list[str],
        results: Mapping[str, TestResult],
        failures: Mapping[str, str],
    ) -> TwinResult:
        done = [test_id for test_id in ids if test_id in results]
        points = pd.concat([results[test_id].points() for test_id in done], ignore_index=True)
        summary = pd.DataFrame(
            [
                {
                    "test_id": test_id,
                    **{k: v for k, v in results[test_id].summary.items() if k != "fingerprint"},
                }
                for test_id in done
            ]
        )
        tests = source.tests[source.tests["test_id"].isin(done)].merge(summary, on="test_id", how="left")
        left_out = [{"test_id": test_id, "reason": failures[test_id]} for test_id in failures]
        info: dict[str, Any] = {
            "synthetic": source.synthetic,
            "kind": KIND,
            "assumptions": list(ASSUMPTIONS),
            "extra_units": EXTRA_UNITS,
            "twin": {"version": TWIN_VERSION, "settings": self._settings()},
            "software": _software(),
            "left_out": left_out,
        }
        for key in ("notice", "plan", "specimen", "plate"):
            if key in source.info:
                info[key] = source.info[key]
        missing = pd.DataFrame(left_out, columns=["test_id", "reason"])
        result = TwinResult(points, tests.reset_index(drop=True), info, missing)
        if result.remarks:
            info["remarks"] = result.remarks
        return result

    def _settings(self) -> dict[str, Any]:
        return asdict(self) | {"thermal": asdict(self.heat)}

    def _fingerprint(self, source: RawCampaign, test_id: str, mass: float) -> str:
        return fingerprint(
            TWIN_VERSION,
            _software(),
            self._settings(),
            mass,
            sorted(source.metadata(test_id).items()),
            source.raw_file(test_id).read_bytes(),
        )


def evaluate_file(twin: SctTwin, folder: str, metadata: dict[str, Any], mass: float) -> TestResult | str:
    """Evaluate one test of a campaign in a pool; a reason where it cannot be."""
    test_id = str(metadata["test_id"])
    try:
        campaign = RawCampaign(Path(folder), pd.DataFrame([metadata]))
        return twin.evaluate(campaign.record(test_id), mass)
    except InputError as error:
        return str(error)


def _loading(signals: TestSignals) -> tuple[np.ndarray, np.ndarray]:
    """Return time and smoothed normal force from the first load to its highest before sliding, never negative."""
    span = slice(max(signals.load_start - 1, 0), signals.slide_start)
    dt = float(signals.t[1] - signals.t[0])
    F_n = np.maximum(smooth(signals.F_n, dt, 20.0)[span], 0.0)
    t = signals.t[span]
    # A wobble of the last sample is not a state: the contact belongs to what the highest force stays near to.
    reached = F_n >= 0.97 * F_n.max()
    first = int(np.argmax(reached))
    return np.append(t[:first], t[first]), np.append(F_n[:first], float(np.median(F_n[reached])))


def _waiting(signals: TestSignals, upset_to: float) -> float:
    """Return how long the specimen has lain under nearly its full load before it slides [s]."""
    loaded = signals.F_n[: signals.slide_start] >= 0.95 * upset_to
    start = int(np.argmax(loaded)) if loaded.any() else signals.slide_start - 1
    return float(signals.t[signals.slide_start] - signals.t[start])


def _sweep(folder: Path) -> None:
    """Remove what a run that was killed has left half-written under a hidden name."""
    for file in (folder / "twin").glob(".*.nc"):
        file.unlink(missing_ok=True)
    for left in (*folder.glob(".dataset.*"), *(folder / AVERAGES).glob(".dataset.*")):
        shutil.rmtree(left, ignore_errors=True)


def _mu_noise(signals: TestSignals) -> float:
    """Return the noise of mu from sample to sample, from second differences of the raw samples."""
    i = signals.slide_start
    span = slice(i + max(2, (len(signals.t) - i) // 4), None)
    mu = signals.friction[span] / np.maximum(signals.F_n[span], 1.0)
    return float(np.std(np.diff(mu, 2)) / np.sqrt(6.0)) if len(mu) > 4 else 0.0


def _software() -> dict[str, str]:
    try:
        return {"tribofmu": version("tribofmu")}
    except PackageNotFoundError:
        return {"tribofmu": "unknown"}


__all__: list[str] = ["SctTwin", "TwinResult"]
