"""`simulate --local-errors`: what the runs with smaller elements say, in the run folder and on the terminal."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
import xarray
from typer.testing import CliRunner

from fmus import pack_forming
from forming import ForwardRodExtrusion, RingCompression
from forming.results.local_errors import ELEMENTS, FINER
from friction_models.common import InputError
from orchestrator.cli.app import app
from orchestrator.cosim.local_errors import FILE, stated_errors
from orchestrator.cosim.run_folders import Run
from orchestrator.report.pages.run import run_page

SIZE, N = 0.5, 30


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    place = tmp_path_factory.mktemp("errors")
    pack_forming(place / "forming.fmu", n_points=N, mesh_size=SIZE)
    for name, more in (("fre", ""), ("few", "record: [forming.force, forming.sigma_n]\n")):
        (place / f"{name}.yaml").write_text(
            f"name: {name}\ncommunication_step: 0.05\nstop_time: 0.2\n{more}"
            "components:\n  forming: {fmu: forming.fmu, start: {mu: 0.08}}\n"
        )
    return place


def test_the_errors_are_those_that_the_process_states(system, tmp_path):
    done = CliRunner().invoke(
        app, ["simulate", str(system / "fre.yaml"), "-o", str(tmp_path / "run"), "--local-errors"]
    )
    assert done.exit_code == 0, done.output
    assert f"elements of {SIZE:g} mm against {FINER * SIZE:.3g} mm" in done.output
    # After 1 mm few points touch: the table above stands on them alone, and the page says so, too.
    run = Run.load(tmp_path / "run")
    said = f"forming: Only {run['forming.active'][1:].sum(axis=1).mean():.2g} of {N} points touch a tool"
    assert said in " ".join(done.output.split())
    page = run_page(run.folder)
    assert said in page
    for error in stated_errors(run):
        assert f"{error.usual:.2g}" in page
    assert "9 of 10 errors are below" in page
    (run.folder / FILE).rename(tmp_path / FILE)
    assert "--local-errors" in run_page(run.folder)
    (tmp_path / FILE).rename(run.folder / FILE)
    with xarray.open_dataset(run.folder / FILE, engine="netcdf4", decode_times=False) as data:
        stated = np.stack([data[name].values for name in ("v_rel", "T", "sigma_n", "sd", "psi")], axis=2)
    process = ForwardRodExtrusion(n_points=N, mesh_size=SIZE)
    contact = process.run(0.08, 1.0, communication_step=0.25, with_errors=True).contact
    assert stated.shape == contact.errors.shape and contact.errors[contact.active].max() > 1.0
    assert stated == pytest.approx(contact.errors, rel=1e-3, abs=1e-6)
    with h5py.File(run.folder / FILE, "r+") as file:
        file["T"].attrs["units"] = "N"
    with pytest.raises(InputError, match=r"local_errors\.nc: unknown unit of column 'T' 'N'; allowed: K"):
        stated_errors(run)


def test_a_run_that_leaves_the_loads_out_is_refused_before_it_starts(system, tmp_path):
    done = CliRunner().invoke(
        app, ["simulate", str(system / "few.yaml"), "-o", str(tmp_path / "run"), "--local-errors"]
    )
    assert isinstance(done.exception, InputError) and not (tmp_path / "run").exists()
    assert "record leaves out forming.v_rel" in str(done.exception)


def test_elements_that_a_process_chooses_itself_get_smaller_too(tmp_path):
    """A ring without mesh_size: its FMU holds 0, two thirds of which is the same mesh."""
    pack_forming(tmp_path / "ring.fmu", process="ring", n_points=N)
    system = (
        "communication_step: 0.05\nstop_time: 0.1\ncomponents: {forming: {fmu: ring.fmu, start: {mu: 0.1}}}\n"
    )
    (tmp_path / "ring.yaml").write_text(system)
    done = CliRunner().invoke(
        app, ["simulate", str(tmp_path / "ring.yaml"), "-o", str(tmp_path / "run"), "--local-errors"]
    )
    assert done.exit_code == 0, done.output
    assert f"elements of the usual size against {FINER:.3g} of it" in " ".join(done.output.split())
    ring = RingCompression(n_points=N)
    contact = ring.run(0.1, 0.1 * ring.speed, communication_step=0.05 * ring.speed, with_errors=True).contact
    expected = [np.median(contact.errors[..., k][contact.active]) for k in range(5)]
    assert min(expected) > 0.0
    assert [e.usual for e in stated_errors(Run.load(tmp_path / "run"))] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("given", ["many", "0.1", "nan"])
def test_a_factor_that_is_none_is_refused(system, tmp_path, monkeypatch, given):
    monkeypatch.setenv(ELEMENTS, given)
    done = CliRunner().invoke(app, ["simulate", str(system / "fre.yaml"), "-o", str(tmp_path / "run")])
    assert f"{ELEMENTS}='{given}'; allowed: 0.2 to 5" in str(done.exception) + done.output


def test_an_fmu_that_knows_no_smaller_elements_states_no_errors(system, tmp_path, monkeypatch):
    monkeypatch.setattr("orchestrator.cosim.local_errors.ELEMENTS", "TRIBOFMU_OTHER")
    done = CliRunner().invoke(
        app, ["simulate", str(system / "fre.yaml"), "-o", str(tmp_path / "run"), "--local-errors"]
    )
    assert done.exit_code == 0, done.output
    assert "errors of the loads are not known: forming does the same" in " ".join(done.output.split())
    assert not (tmp_path / "run" / FILE).exists()
