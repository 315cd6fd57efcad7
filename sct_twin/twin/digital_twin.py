"""The digital twin of the sliding compression test: from a campaign of raw records to data sets of loads and friction."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pandas as pd

from friction_models.common import InputError, check_folder, grown
from friction_models.common.cached_results import fingerprint
from friction_models.common.folders import TWIN
from friction_models.common.processes.pool import Progress, map_unordered

from ..ingest.raw_campaign import RawCampaign
from . import error_study
from .campaign_result import AVERAGES, KIND, TwinResult, remarks_in
from .evaluation import REMARK, TwinSettings, evaluate_file
from .test_result import ASSUMPTIONS, EXTRA_UNITS, TestResult, read_netcdf, write_netcdf

#: Changes when the same inputs give other results.
TWIN_VERSION = 7


@dataclass
class SctTwin(TwinSettings):
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
    uncertainty : GivenUncertainty or None
        Standard uncertainties of what the twin is given, from which those of the loads follow (columns
        `u_sigma_n`, `u_psi`, `u_T`); None: these columns are left out, which saves about half the time.

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

    Examples
    --------
    Settings first; `run` then takes a campaign.

    >>> from sct_twin import SctTwin
    >>> twin = SctTwin(spacing=0.5, upsetting_mu=None)
    >>> twin.spacing, twin.material.name
    (0.5, '16MnCr5')
    >>> SctTwin(mesh_size=5.0)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: SCT twin: mesh_size = 5.0 mm; allowed: 0.2 to 1.5 mm
    """

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
        report(len(results), len(ids), f"{len(results)} tests known" if results else "first tests")
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
            done = [test_id for test_id in ids if test_id in results]
            result.errors = error_study.check(self, source, done, check, jobs, progress)
            result.info["errors"] = {"unit": "%", "largest": error_study.summary(result.errors)}
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
        summary = pd.DataFrame([{"test_id": test_id, **results[test_id].summary} for test_id in done])
        doubtful = remarks_in(summary, REMARK)
        summary = summary.drop(columns=["fingerprint", REMARK], errors="ignore")
        tests = source.tests[source.tests["test_id"].isin(done)].merge(summary, on="test_id", how="left")
        left_out = [{"test_id": test_id, "reason": reason} for test_id, reason in failures.items()]
        info: dict[str, object] = {
            "synthetic": source.synthetic,
            "kind": KIND,
            "assumptions": list(ASSUMPTIONS),
            "extra_units": EXTRA_UNITS,
            "twin": {"version": TWIN_VERSION, "settings": self._settings()},
            "software": _software(),
            "left_out": left_out,
        }
        about = ("notice", "plan", "specimen", "plate")
        info |= {key: source.info[key] for key in about if key in source.info}
        missing = pd.DataFrame(left_out, columns=["test_id", "reason"])
        result = TwinResult(points, tests.reset_index(drop=True), info, missing, doubtful=doubtful)
        if result.remarks:
            info["remarks"] = result.remarks
        return result

    def _settings(self) -> dict[str, object]:
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


def _sweep(folder: Path) -> None:
    """Remove what a run that was killed has left half-written under a hidden name."""
    for file in (folder / "twin").glob(".*.nc"):
        file.unlink(missing_ok=True)
    for left in (*folder.glob(".dataset.*"), *(folder / AVERAGES).glob(".dataset.*")):
        shutil.rmtree(left, ignore_errors=True)


def _software() -> dict[str, str]:
    try:
        return {"tribofmu": version("tribofmu")}
    except PackageNotFoundError:
        return {"tribofmu": "unknown"}
