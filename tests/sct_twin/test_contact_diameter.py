"""A measured diameter of the contact tells the twin what the forces cannot: a flow stress that is not the table's."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from forming.materials.materials import Material, steel_16MnCr5
from forming.tools.punch_geometry import PunchGeometry
from friction_models.common import InputError
from sct_twin import RawCampaign, SctRecord, SctTwin
from sct_twin.twin.contact_reading import growth, read_at_diameter
from sct_twin.twin.upsetting import UpsettingCase, UpsettingRun, known_upset, run_force

Maker = Callable[..., SctRecord]
#: A tip that has folded down in part: the area grows about as fast as the force.
PUNCH = PunchGeometry(bore_diameter=20.0, tip_diameter=8.944)
FORCE, MESH = 157e3, 0.7


def upset_to(force: float, material: Material, T: float = 20.0) -> UpsettingRun:
    case = UpsettingCase(PUNCH, run_force(force), MESH, material, 0.07, T, T)
    return UpsettingRun(known_upset(case, "test"), case)


def of_the_table(force: float) -> UpsettingRun:
    return upset_to(force, steel_16MnCr5())


def test_harder_steel_is_recovered() -> None:
    steel = steel_16MnCr5()
    true = upset_to(FORCE, replace(steel, A=1.03 * steel.A)).at(FORCE)
    wrong = of_the_table(FORCE).at(FORCE)
    assert growth(of_the_table(FORCE), FORCE) > 0.5
    assert wrong.area > 1.025 * true.area
    found = read_at_diameter(of_the_table, FORCE, 2.0 * true.radius, PUNCH)
    state = found.upsetting.at(FORCE)
    assert found.use == "force and area" and found.remark == ""
    # The two runs have meshes of their own: each reads the radius to 0.3 %.
    assert found.upsetting.flow_stress == pytest.approx(1.03, abs=0.01)
    assert state.area == pytest.approx(true.area, rel=5e-4)
    assert state.psi == pytest.approx(true.psi, rel=0.004)
    assert state.height == pytest.approx(true.height, rel=0.005)
    assert state.T_specimen == pytest.approx(true.T_specimen, abs=0.5)
    # The pressure carries the whole force, and is that of the harder steel.
    carried = np.trapezoid(2.0 * state.radius_fraction * state.pressure, state.radius_fraction)
    assert float(carried) == pytest.approx(FORCE / true.area, rel=5e-3)
    assert state.pressure[:20] == pytest.approx(true.pressure[:20], rel=0.03)


def test_softer_steel_is_read_beyond_the_usual_run() -> None:
    asked: list[float] = []

    def run_to(force: float) -> UpsettingRun:
        asked.append(force)
        return of_the_table(force)

    wanted = of_the_table(1.15 * FORCE).at(1.12 * FORCE)
    found = read_at_diameter(run_to, FORCE, 2.0 * wanted.radius, PUNCH)
    assert asked == [FORCE, pytest.approx(1.15 * FORCE)]
    assert found.upsetting.flow_stress == pytest.approx(1.0 / 1.12, rel=1e-3)
    assert found.upsetting.at(FORCE).area == pytest.approx(wanted.area, rel=1e-3)


@pytest.mark.parametrize("factor", [0.85, 1.2])
def test_a_diameter_that_cannot_be_is_not_used(factor: float) -> None:
    upsetting = of_the_table(FORCE)
    expected = 2.0 * upsetting.at(FORCE).radius
    found = read_at_diameter(of_the_table, FORCE, factor * expected, PUNCH)
    assert found.upsetting.flow_stress == 1.0 and found.use == "not used"
    assert f"contact_diameter = {factor * expected:g} mm" in found.remark
    assert "allowed: " in found.remark and "the measured one was not used" in found.remark


def test_a_little_beyond_the_run_the_area_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    # Shifts of 1 % only: the diameter needs more, but it may well be the contact's.
    monkeypatch.setattr("sct_twin.twin.contact_reading.SHIFTS", (0.99, 1.01))
    expected = 2.0 * of_the_table(FORCE).at(FORCE).radius
    found = read_at_diameter(of_the_table, FORCE, 0.985 * expected, PUNCH)
    assert found.use == "area" and found.upsetting.flow_stress == 1.0
    assert 2.0 * found.upsetting.at(FORCE).radius == pytest.approx(0.985 * expected, rel=1e-9)


def filled(record_maker: Maker, diameter: object) -> SctRecord:
    record = record_maker()
    factor = 4.0
    return replace(
        record,
        F_n=record.F_n * factor,
        F_r=record.F_r * factor,
        metadata={**record.metadata, "contact_diameter": diameter},
    )


def test_a_filled_bore_is_not_changed(record_maker: Maker) -> None:
    twin = SctTwin(mesh_size=MESH, spacing=0.5)
    record = filled(record_maker, None)
    without = twin.evaluate(record)
    assert without.summary["contact_area"] == pytest.approx(math.pi / 4.0 * 15.51**2, rel=1e-3)
    assert "flow_stress_ratio" not in without.summary
    for diameter, fits in ((15.58, True), (14.9, False)):
        compared = twin.evaluate(filled(record_maker, diameter))
        assert all(np.array_equal(compared.columns[name], without.columns[name]) for name in without.columns)
        assert compared.summary["contact_diameter_use"] == ("compared" if fits else "not used")
        assert compared.summary["flow_stress_ratio"] == 1.0
        remark = str(compared.summary["contact_diameter_remark"])
        assert (remark == "") == fits
    assert "contact_diameter = 14.9 mm" in remark and "allowed: 15.20 to 15.82 mm for this" in remark


def test_pressure_of_a_test_is_force_over_the_measured_area(record_maker: Maker) -> None:
    record = record_maker()
    shape = {"T_tool": 20.0, "bore": 20.0, "tip": 8.944}
    twin = SctTwin(mesh_size=MESH, spacing=0.5)
    scale = FORCE / 94e3
    record = replace(record, F_n=record.F_n * scale, F_r=record.F_r * scale, metadata=shape)
    without = twin.evaluate(record)
    area = 0.96 * float(without.summary["contact_area"])
    diameter = 2.0 * math.sqrt(area / math.pi)
    result = twin.evaluate(replace(record, metadata={**shape, "contact_diameter": diameter}))
    assert result.summary["contact_diameter_use"] == "force and area"
    assert 1.02 < float(result.summary["flow_stress_ratio"]) < 1.08
    assert result.columns["sigma_n"] * area == pytest.approx(result.columns["F_n"], rel=1e-3)
    assert (result.columns["psi"] < without.columns["psi"]).all()
    # It was upset less, so that it starts colder; then the heat on a smaller area counts.
    later = result.columns["sd"] > 8.0
    assert (result.columns["T"] > without.columns["T"])[later].all()


def test_area_of_a_contact_that_hardly_grows_is_the_measured_one(record_maker: Maker) -> None:
    twin = SctTwin(mesh_size=MESH, spacing=0.5)
    record = record_maker()
    without = twin.evaluate(record)
    expected = 2.0 * math.sqrt(float(without.summary["contact_area"]) / math.pi)
    assert expected < 0.995 * 15.51
    metadata = {**record.metadata, "contact_diameter": 0.99 * expected}
    result = twin.evaluate(replace(record, metadata=metadata))
    assert result.summary["contact_diameter_use"] == "area" and result.summary["flow_stress_ratio"] == 1.0
    assert result.columns["sigma_n"] == pytest.approx(without.columns["sigma_n"] / 0.99**2, rel=1e-6)
    assert np.array_equal(result.columns["psi"], without.columns["psi"])
    assert (result.columns["T"][1:] > without.columns["T"][1:]).all()
    # nearly as large as fits: after a change of the friction it would not, which is no uncertainty of the pressure
    metadata = {**record.metadata, "contact_diameter": 1.0198 * expected}
    nearly = twin.evaluate(replace(record, metadata=metadata))
    relative = [r.columns["u_sigma_n"] / r.columns["sigma_n"] for r in (result, nearly)]
    assert nearly.summary["contact_diameter_use"] == "area"
    assert (relative[1] <= 1.02 * relative[0]).all()


def test_what_does_not_fit_is_said_in_the_data_set(tiny: RawCampaign, tmp_path: Path) -> None:
    # One campaign of two tests: a diameter that cannot be one, and one that does not fit.
    folder = tmp_path / "campaign"
    (folder / "raw").mkdir(parents=True)
    tests = tiny.tests.iloc[:3].assign(contact_diameter=[-3.0, 27.0, np.nan])
    for test_id in tests["test_id"]:
        (folder / "raw" / f"{test_id}.csv").write_bytes(tiny.raw_file(test_id).read_bytes())
    tests.to_csv(folder / "tests.csv", index=False)
    (folder / "campaign.json").write_text((tiny.folder / "campaign.json").read_text())
    result = SctTwin(mesh_size=MESH, spacing=1.0).run(folder, out=tmp_path / "data", jobs=1)
    bad, odd, _ = tests["test_id"]
    assert result.left_out["test_id"].tolist() == [bad]
    reason = result.left_out["reason"][0]
    assert "'contact_diameter' is -3.0; allowed: 1.5 to 30 mm, or empty" in reason
    assert [r["test_id"] for r in result.remarks] == [odd]
    assert "27 mm" in (tmp_path / "data" / "dataset.json").read_text()
    kept = pd.read_csv(tmp_path / "data" / "tests.csv").set_index("test_id")
    assert kept["flow_stress_ratio"].isna().tolist() == [False, True]


@pytest.mark.parametrize("value", [0.0, -15.0, 0.0155, 240.0, math.inf, "wide"])
def test_values_that_are_no_diameter(record_maker: Maker, value: object) -> None:
    with pytest.raises(InputError, match=r"metadata 'contact_diameter' is .*; allowed: "):
        SctTwin().evaluate(filled(record_maker, value))
