"""Exports for hosts that take numbers, not code: read back by the host's rules, and the deviation that they state."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from fmus.exports import export
from fmus.exports.numbers.deviation import POINTS, domain_points
from fmus.runtime.running import RunningFmu
from friction_models.common import InputError
from tests.fmus.exported import fmu_at, made
from tests.fmus.graphs import Array

#: Units of a deck, written out: mm/s a speed, MPa a pressure, and degC to its temperature.
UNITS = {
    "tonne-mm-s": (1.0, 1.0, "degC", lambda T: T),
    "kg-m-s": (1e3, 1e-6, "K", lambda T: T + 273.15),
    "kg-mm-ms": (1e3, 1e3, "degC", lambda T: T),
}


def data_lines(folder: Path, keyword: str) -> Array:
    """The numbers behind a keyword, as Abaqus and CalculiX read them."""
    text = next(folder.glob("*.inp")).read_text().split(f"\n{keyword}", 1)[1].split("\n", 1)[1]
    return np.array(
        [[float(x) for x in row.split(",")] for row in text.split("*", 1)[0].strip().splitlines()]
    )


def by_abaqus_rules(rows: Array, at: Array) -> Array:
    """Interpolate as the Keywords Guide says: first load fastest, linear in between, constant outside."""
    from scipy.interpolate import RegularGridInterpolator

    lines = [np.unique(column) for column in rows[:, 1:].T]
    order = np.lexsort(rows[:, 1:].T)
    assert np.array_equal(order, np.arange(len(rows)))  # first load fastest, all ascending
    values = rows[:, 0].reshape([len(x) for x in lines[::-1]])
    inside = np.column_stack([np.clip(a, x[0], x[-1]) for a, x in zip(at.T, lines)])
    return np.asarray(RegularGridInterpolator(lines[::-1], values)(inside[:, ::-1]))


@pytest.mark.parametrize("units", ["tonne-mm-s", "kg-m-s"])
def test_abaqus_table_is_as_far_from_the_fmu_as_it_says(units: str, tmp_path: Path) -> None:
    model = made("polynomial")
    speed, pressure, warm, temperature = UNITS[units]
    options = {"units": units, "temperature": warm, "tolerance": 5e-4, "name": "law"}
    folder = export(model.source, tmp_path / "table", "abaqus", **options)
    report = json.loads((folder / "table.json").read_text())
    points, mu = domain_points(model.source)
    host = np.column_stack([points[:, 0] / speed, points[:, 2] / pressure, temperature(points[:, 1])])
    found = by_abaqus_rules(data_lines(folder, "*FRICTION"), host)
    stated = report["remaining"]["largest deviation"]
    assert np.abs(found - mu).max() == pytest.approx(stated, abs=2e-8)
    assert report["remaining"]["points"] == len(points) == POINTS == 10_000
    with RunningFmu(model.fmu) as fmu:  # not only against ONNX Runtime
        some = points[:200]
        np.testing.assert_allclose(fmu_at(fmu, some), mu[:200], rtol=1e-12)
    # All five loads, with sd and psi as field variables: what remains is interpolation alone.
    full = export(model.source, tmp_path / "full", "abaqus", fields=["sd", "psi"], max_rows=40_000, **options)
    assert "*FRICTION, DEPENDENCIES=2" in (full / "law_friction.inp").read_text()
    rows = data_lines(full, "*FRICTION")
    assert rows.shape[1] == 6
    host = np.column_stack([host, points[:, 3] / (1e3 if units == "kg-m-s" else 1.0), points[:, 4]])
    error = np.abs(by_abaqus_rules(rows, host) - mu).max()
    assert error < 2e-3 < stated
    assert error == pytest.approx(
        json.loads((full / "table.json").read_text())["remaining"]["largest deviation"], abs=2e-8
    )


def test_abaqus_refuses_memory_and_fields_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="a table has no memory"):
        export(made("linear + work_exhaustion").source, tmp_path / "x", "abaqus")
    with pytest.raises(InputError, match=r"fields = \['T'\], allowed: any of sd, psi"):
        export(made("polynomial").source, tmp_path / "x", "abaqus", fields=["T"])
    folder = export(made("linear + work_exhaustion").source, tmp_path / "fresh", "abaqus", start_memory=True)
    assert "THIS MODEL HAS MEMORY" in (folder / "README.txt").read_text()


def by_radioss(folder: Path, v: Array, p: Array) -> Array:
    """Read the card by columns of 10 and 20, and evaluate the formulas of the engine's contact type 7."""
    lines = [x for x in next(folder.glob("*.rad")).read_text().splitlines() if not x.startswith("#")]
    assert lines[0] == "/FRICTION/1"
    ifric, iform = int(lines[2][:10]), int(lines[2][40:50])
    assert iform == 2
    c = [float(lines[3][20 * k : 20 * k + 20]) for k in range(5)] + [float(lines[4][:20])]
    fric = float(lines[4][20:40])
    if ifric == 1:
        return np.asarray(fric + c[0] * p + c[1] * v + c[2] * p * v + c[3] * p * p + c[4] * v * v)
    return np.asarray(
        fric + c[0] * np.exp(c[1] * v) * p * p + c[2] * np.exp(c[3] * v) * p + c[4] * np.exp(c[5] * v)
    )


@pytest.mark.parametrize("name", ["polynomial", "power_law", "linear + work_exhaustion"])
def test_radioss_formula_is_as_far_from_the_model_as_it_says(name: str, tmp_path: Path) -> None:
    source = made(name).source
    points, mu = domain_points(source)
    for units in ("tonne-mm-s", "kg-mm-ms"):
        speed, pressure, _, _ = UNITS[units]
        folder = export(source, tmp_path / units, "radioss", units=units)
        report = json.loads((folder / "fit.json").read_text())
        found = by_radioss(folder, points[:, 0] / speed, points[:, 2] / pressure)
        assert np.abs(found - mu).max() == pytest.approx(report["remaining"]["largest deviation"], rel=1e-6)
    if (
        name == "polynomial"
    ):  # second order in pressure and speed: nothing is left but the loads that are held
        assert report["largest deviation at the held loads, by Ifric"]["1"] < 1e-12
    if source.states:
        assert "THIS MODEL HAS MEMORY" in (folder / "README.txt").read_text()


def test_calculix_has_the_ratio_of_forces_that_was_exported(tmp_path: Path) -> None:
    source = made("polynomial").source
    folder = export(source, tmp_path / "ccx", "calculix", name="law")
    ((mu, slope),) = data_lines(folder, "*FRICTION")
    points, all_mu = domain_points(source)
    stated = json.loads((folder / "fit.json").read_text())["remaining"]["largest deviation"]
    assert np.abs(all_mu - mu).max() == pytest.approx(stated, rel=1e-9)
    assert stated == pytest.approx(0.5 * np.ptp(all_mu), rel=1e-6)  # no other coefficient is nearer
    at = dict(zip(("v_rel", "T", "sigma_n", "sd", "psi"), points[0].tolist()))
    there = export(source, tmp_path / "there", "calculix", fixed=at)
    assert data_lines(there, "*FRICTION")[0, 0] == pytest.approx(all_mu[0], rel=1e-8)
    if shutil.which("ccx") is None:
        pytest.skip("CalculiX (ccx) is not installed: the export is not run in it")
    deck = (Path(__file__).parent / "sliding_block.inp").read_text().replace("@NAME@", "law_friction")
    (folder / "job.inp").write_text(deck)
    subprocess.run(["ccx", "job"], cwd=folder, capture_output=True, check=True, timeout=60)
    tangential, _, normal = map(float, (folder / "job.dat").read_text().split()[-3:])
    assert normal > 100.0
    assert -tangential / normal == pytest.approx(mu, rel=1e-4)
    assert slope > 0.0


def test_fitted_hosts_take_the_values_of_system_variables(tmp_path: Path) -> None:
    source = made("linear + tool_roughness").source
    [ra] = source.system
    assert ra.upper is not None
    for value in (ra.start, ra.upper):
        given = {} if value == ra.start else {"system": {ra.name: value}}
        points, mu = domain_points(source, {ra.name: value})
        folder = export(source, tmp_path / f"radioss {value}", "radioss", **given)
        stated = json.loads((folder / "fit.json").read_text())["remaining"]["largest deviation"]
        assert np.abs(by_radioss(folder, points[:, 0], points[:, 2]) - mu).max() == pytest.approx(
            stated, rel=1e-6
        )
        assert f"{ra.name} is held at {value:.4g}" in (folder / "README.txt").read_text()
        folder = export(source, tmp_path / f"ccx {value}", "calculix", **given)
        assert data_lines(folder, "*FRICTION")[0, 0] == pytest.approx(0.5 * (mu.min() + mu.max()), rel=1e-8)
        assert f"{ra.name} is held at {value:.4g}" in (folder / "README.txt").read_text()
        at = dict(zip(("v_rel", "T", "sigma_n", "sd", "psi"), points[0].tolist()))
        there = export(source, tmp_path / f"there {value}", "calculix", fixed=at, **given)
        assert data_lines(there, "*FRICTION")[0, 0] == pytest.approx(mu[0], rel=1e-8)
    for target in ("radioss", "calculix"):
        with pytest.raises(InputError, match="Rb"):
            export(source, tmp_path / "x", target, system={"Rb": 1.0})
