"""The twin against the laboratory's truth, which comes from another resolution and another material."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from friction_models.loads import POINT_COLUMNS, DataSet, InputError
from sct_twin import RawCampaign, SctTwin, TwinResult
from sct_twin.ingest import ingest
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
    assert (error[:, 0] < 0.06).all() and error[:, 0].mean() < 0.025
    # A contact that has not filled the bore is known to a node of the mesh.
    assert (error[:, 1] < 0.07).all() and error[:, 1].mean() < 0.025
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
    SctTwin(spacing=0.5).run(tiny, out=tmp_path / "data", jobs=1)
    assert len(computed) == 10  # other settings: everything anew


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
    with pytest.raises(InputError, match=r"spacing = 0.0; allowed: 0.01 to 10 mm"):
        SctTwin(spacing=0.0)
    (tmp_path / "raw").mkdir()
    (tmp_path / "campaign.json").write_text("{}")
    (tmp_path / "tests.csv").write_text("test_id,T_tool\n../x,20\n")
    with pytest.raises(InputError, match=r"test_id '../x'; allowed: a name that can be a file name"):
        RawCampaign.load(tmp_path)
