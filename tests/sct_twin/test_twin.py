"""The twin against the laboratory's truth, which comes from another resolution and another material."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from friction_models.common import InputError
from friction_models.estimation.campaign.metadata import EVALUATED, metadata_columns
from friction_models.loads import POINT_COLUMNS, DataSet
from sct_twin import RawCampaign, SctTwin, TwinResult
from sct_twin.ingest.campaign_files import ingest
from sct_twin.twin import contact_reading
from sct_twin.twin.test_result import read_netcdf
from sct_twin.virtual_lab import load_truth


def test_loads_and_friction_meet_the_truth(tiny: RawCampaign, twinned: tuple[TwinResult, Path]) -> None:
    result, _ = twinned
    _, truth = load_truth(tiny.folder)
    assert len(truth) == 9
    tests = result.tests.set_index("test_id")
    worst = []
    for test_id, points in result.points.groupby("test_id"):
        true = truth[str(test_id)]
        count = min(len(points), len(true["sd"]))
        p = {name: points[name].to_numpy()[:count] for name in points.columns}
        t = {name: values[:count] for name, values in true.items()}
        assert np.allclose(p["sd"], t["sd"])
        rise = (t["T"] - tests.loc[test_id, "T_tool"]).mean()
        worst.append(
            (
                np.abs(p["T"] - t["T"]).mean() / rise,
                abs(p["sigma_n"].mean() / t["sigma_n"].mean() - 1.0),
                abs(p["psi"].mean() / t["psi"].mean() - 1.0),
            )
        )
        # Two samples a point at most at high speed: the fluctuation from sample to sample stays.
        assert np.std(p["mu"] - t["mu"]) < 1.5e-3
        assert abs(np.mean(p["mu"] - t["mu"])) < 4e-4
        assert np.abs(p["v_rel"][20:] / t["v_rel"][20:] - 1.0).max() < 0.03
    error = np.array(worst)
    # The laboratory's steel is 1.5 % harder than the twin's, and its specimens scatter; where a taper folds down
    # the area grows with twice the relative force, and two tests in nine are such.
    assert (error[:, 0] < 0.045).all() and np.median(error[:, 0]) < 0.015
    assert (error[:, 1] < 0.045).all() and np.median(error[:, 1]) < 0.01
    assert (error[:, 2] < 0.03).all()


def test_points_are_a_data_set(twinned: tuple[TwinResult, Path]) -> None:
    result, folder = twinned
    assert tuple(result.points.columns[: len(POINT_COLUMNS)]) == POINT_COLUMNS
    train, test = result.frames()
    assert train["test_id"].nunique() == 6 and test["test_id"].nunique() == 3
    data = DataSet.load(folder)
    assert data.synthetic and len(data.points) == len(result.points)
    assert np.allclose(data.points["mu"], result.points["mu"])
    loads = data.loads()
    assert loads.context_column("T_tool") is not None


def test_what_the_twin_adds_to_the_test_table_is_no_metadata(
    tiny: RawCampaign, twinned: tuple[TwinResult, Path]
) -> None:
    result, folder = twinned
    settings = set(metadata_columns(DataSet.load(folder).loads()))
    added = set(result.tests.columns) - set(tiny.tests.columns)
    assert {"mu_mean", "psi_mean"} <= added, "it adds averages that follow from mu"
    contact = {"flow_stress_ratio", contact_reading.USE, "contact_diameter_remark"}
    assert contact <= EVALUATED, "added where a diameter was measured"
    assert settings & added <= {"F_r_zero", "F_r_zero_end"}, (
        "the zero of the force sensor is read, not evaluated"
    )
    assert "T_tool" in settings


def test_averages_are_a_data_set_beside(twinned: tuple[TwinResult, Path]) -> None:
    result, folder = twinned
    means = DataSet.load(folder / "averages")
    assert means.synthetic and "average" in means.info["kind"]
    assert means.tests["test_id"].tolist() == result.tests["test_id"].tolist()
    assert len(means.points) == 9 and means.points["test_id"].is_unique
    one = result.points[result.points["test_id"] == "sct002"]
    row = means.points.set_index("test_id").loc["sct002"]
    assert row["sigma_n"] == pytest.approx(one["sigma_n"].mean())
    assert row["mu"] == pytest.approx(one["F_r"].sum() / one["F_n"].sum())
    assert row["mu"] == pytest.approx(one["mu"].mean(), rel=0.01)
    # A model can be trained on it like on any data set.
    train, test = means.frames()
    assert len(train) == 6 and len(test) == 3


def test_netcdf_files_state_what_they_are(twinned: tuple[TwinResult, Path]) -> None:
    result, folder = twinned
    with xr.open_dataset(folder / "twin" / "sct001.nc") as data:
        assert data.attrs["synthetic"] == "true"
        assert "contact pressure and surface expansion keep their shape" in data.attrs["assumptions"]
        assert data["T"].attrs["units"] == "degC"
        expected = result.points[result.points["test_id"] == "sct001"]["T"]
        assert np.array_equal(data["T"].to_numpy(), expected)


def test_finished_tests_are_not_computed_again(
    tiny: RawCampaign, twinned: tuple[TwinResult, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result, folder = twinned
    shutil.copytree(folder, tmp_path / "data")
    (tmp_path / "data" / "twin" / "sct003.nc").write_bytes(b"damaged")
    computed: list[str] = []
    evaluate = SctTwin.evaluate

    def counted(self: SctTwin, record, moving_mass=None):  # type: ignore[no-untyped-def]
        computed.append(record.test_id)
        return evaluate(self, record, moving_mass)

    monkeypatch.setattr(SctTwin, "evaluate", counted)
    again = SctTwin().run(tiny, out=tmp_path / "data", jobs=1)
    assert computed == ["sct003"]
    assert np.array_equal(again.points["T"], result.points["T"])
    shutil.copytree(tiny.folder, tmp_path / "two")
    few = pd.read_csv(tiny.folder / "tests.csv").iloc[:2]
    few.to_csv(tmp_path / "two" / "tests.csv", index=False)
    SctTwin(spacing=0.5).run(tmp_path / "two", out=tmp_path / "data", jobs=1)
    assert computed[1:] == few["test_id"].tolist()  # other settings: everything anew


def test_a_killed_run_goes_on_bit_for_bit(
    tiny: RawCampaign, twinned: tuple[TwinResult, Path], tmp_path: Path
) -> None:
    result, _ = twinned
    out = tmp_path / "data"
    script = "import sys; from sct_twin import SctTwin; SctTwin().run(sys.argv[1], out=sys.argv[2], jobs=1)"
    command = [sys.executable, "-c", script, str(tiny.folder), str(out)]
    with subprocess.Popen(command) as running:
        finished: list[Path] = []
        while running.poll() is None and len(finished) < 2:
            time.sleep(0.02)
            finished = list((out / "twin").glob("sct*.nc"))
        running.kill()
    assert running.returncode == -signal.SIGKILL and len(finished) >= 2
    assert not (out / "points.csv").exists()
    kept = {file.name: file.read_bytes() for file in (out / "twin").glob("sct*.nc")}
    (out / "twin" / ".sct009.nc.half.nc").write_bytes(b"half a file")
    (out / ".dataset.half").mkdir()
    assert all(read_netcdf(out / "twin" / name) is not None for name in kept)
    seen: list[str] = []
    again = SctTwin().run(tiny, out=out, jobs=1, progress=lambda done, total, what: seen.append(what))
    assert seen[0] == f"{len(kept)} tests known" and len(seen) == 10 - len(kept)
    pd.testing.assert_frame_equal(again.points, result.points, check_exact=True)
    pd.testing.assert_frame_equal(again.tests, result.tests, check_exact=True)
    assert kept == {name: (out / "twin" / name).read_bytes() for name in kept}
    assert sorted(path.name for path in out.iterdir()) == [
        ".tribofmu",
        "averages",
        "dataset.json",
        "points.csv",
        "tests.csv",
        "twin",
    ]
    assert len(list((out / "twin").iterdir())) == 9


def test_errors_of_fidelity_and_assumptions(tiny: RawCampaign, tmp_path: Path) -> None:
    folder = tmp_path / "c"
    shutil.copytree(tiny.folder, folder)
    few = [str(test_id) for test_id in list(tiny.tests["test_id"])[:2]]
    tests = pd.read_csv(folder / "tests.csv")
    tests[tests["test_id"].isin(few)].to_csv(folder / "tests.csv", index=False)
    result = SctTwin().run(folder, out=tmp_path / "data", jobs=1, check=1)
    errors = pd.read_csv(tmp_path / "data" / "errors.csv").set_index("variant")
    assert set(errors["test_id"]) == {few[0]} and len(errors) == 9
    assert errors.loc["finer mesh and grid", ["sigma_n", "psi"]].abs().max() < 2.0
    assert errors.loc["finer mesh and grid", "T"] == pytest.approx(0.0, abs=3.0)
    # What concerns the sliding only leaves the contact alone; harder steel, smaller contact.
    for variant in ("interface heat transfer x 0.5", "heat data of 20 degC", "contact heated evenly"):
        assert errors.loc[variant, "sigma_n"] == errors.loc[variant, "psi"] == 0.0
    # The bore of this test is filled: its pressure is nearly even, but for the edge.
    assert -3.0 < errors.loc["contact heated evenly", "T_max"] < -0.1
    assert errors.loc["flow stress x 1.02", "sigma_n"] > 0.0
    assert result.info["errors"]["largest"]["flow stress x 1.02"]["sigma_n"] > 0.0
    assert "flow stress x 1.02" in result.error_table()
    # A run that does not ask again keeps them, beside the points that they are of.
    SctTwin().run(folder, out=tmp_path / "data", jobs=1)
    assert set(pd.read_csv(tmp_path / "data" / "errors.csv")["test_id"]) == {few[0]}
    other = SctTwin(upsetting_mu=0.05).run(folder, out=tmp_path / "data", jobs=1)
    assert not (tmp_path / "data" / "errors.csv").exists()
    assert other.put_aside == tmp_path / "data" / "errors.csv.1"
    assert set(pd.read_csv(other.put_aside)["test_id"]) == {few[0]}
    with pytest.raises(InputError, match="check = -1 tests"):
        SctTwin().run(folder, check=-1)


def test_a_bad_record_is_left_out(tiny: RawCampaign, tmp_path: Path) -> None:
    folder = tmp_path / "c"
    shutil.copytree(tiny.folder, folder)
    for test_id in list(tiny.tests["test_id"])[:6]:
        (folder / "raw" / f"{test_id}.csv").write_text("t,F_n\ns,N\n0,1\n")
    result = SctTwin().run(folder, jobs=1)
    assert len(result.tests) == 3 and len(result.left_out) == 6
    assert "is missing" in result.left_out["reason"][0]
    assert len(result.info["left_out"]) == 6
    for test_id in list(tiny.tests["test_id"])[6:]:
        (folder / "raw" / f"{test_id}.csv").write_text("")
    with pytest.raises(InputError, match="none of 9 tests can be evaluated"):
        SctTwin().run(folder, out=tmp_path / "out", jobs=1)


def test_records_of_a_folder_written_by_hand_are_checked_as_by_ingest(
    tiny: RawCampaign, tmp_path: Path
) -> None:
    folder = tmp_path / "c"
    shutil.copytree(tiny.folder, folder)
    turned, falls, cut = (str(test_id) for test_id in list(tiny.tests["test_id"])[:3])

    def changed(test_id: str, change: Callable[[pd.DataFrame], pd.DataFrame]) -> None:
        file = folder / "raw" / f"{test_id}.csv"
        head = file.read_text().splitlines()[:2]
        rows = change(pd.read_csv(file, skiprows=[1]))
        file.write_text("\n".join([*head, rows.to_csv(index=False, header=False)]))

    changed(turned, lambda rows: rows.assign(F_n=-rows["F_n"]))

    def let_go(rows: pd.DataFrame) -> pd.DataFrame:
        gone = rows["s"].between(*rows["s"].quantile([0.5, 0.7]))
        return rows.assign(F_n=rows["F_n"].where(~gone, 0.0), F_r=rows["F_r"].where(~gone, 0.0))

    changed(falls, let_go)
    moves = "the plate moves from the first sample on"
    changed(
        cut, lambda rows: rows[(rows["s"] > rows["s"].min() + 1.0) & (rows["F_n"] > 0.5 * rows["F_n"].max())]
    )
    result = SctTwin().run(folder, jobs=1)
    reasons = dict(zip(result.left_out["test_id"], result.left_out["reason"]))
    assert set(reasons) == {turned, cut}
    assert "compression as positive numbers" in reasons[turned]
    assert moves in reasons[cut]  # and nothing about a sign
    (remark,) = result.remarks
    assert remark["test_id"] == falls
    assert "spikes in F_n, left in" in remark["remark"]
    assert result.info["remarks"] == result.remarks


def test_ingest_of_virtual_files_keeps_the_label(tiny: RawCampaign, tmp_path: Path) -> None:
    report = ingest(tiny.folder, None, tmp_path / "again")
    assert len(report.quality) == 9 and report.left_out.empty
    assert report.campaign.synthetic
    assert report.campaign.moving_mass == tiny.moving_mass
    assert not (tmp_path / "again" / "truth.npz").exists()
    # Empty cells of the test table stay empty, numbers stay numbers.
    assert report.campaign.tests["T_tool"].tolist() == tiny.tests["T_tool"].tolist()


def test_not_a_campaign(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not a raw campaign"):
        SctTwin().run(tmp_path)
    (tmp_path / "raw").mkdir()
    (tmp_path / "campaign.json").write_text("{")
    with pytest.raises(InputError, match=r"campaign.json: not readable JSON"):
        SctTwin().run(tmp_path)
    (tmp_path / "campaign.json").write_text(json.dumps({}))
    (tmp_path / "tests.csv").write_text("test_id\nx\n")
    with pytest.raises(InputError, match=r"test 'x' has no file raw/x.csv"):
        SctTwin().run(tmp_path)


def test_names_and_settings_that_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"spacing = 0.0 mm; allowed: 0.01 to 10 mm"):
        SctTwin(spacing=0.0)
    (tmp_path / "raw").mkdir()
    (tmp_path / "campaign.json").write_text("{}")
    (tmp_path / "tests.csv").write_text("test_id,T_tool\n../x,20\n")
    with pytest.raises(InputError, match=r"test_id '../x'; allowed: a name that can be a file name"):
        RawCampaign.load(tmp_path)
