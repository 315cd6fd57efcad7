"""`simulate --local-errors`: what the runs with smaller elements say, in the run folder and on the terminal."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
import xarray
from typer.testing import CliRunner

from fmus import pack_forming
from forming import ForwardRodExtrusion
from forming.results.local_errors import FINER, local_errors
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


def test_the_errors_are_those_of_two_runs_of_the_process(system, tmp_path):
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
    contacts = []
    for size in (SIZE, FINER * SIZE):
        process = ForwardRodExtrusion(n_points=N, mesh_size=size)
        contact = process.run(0.08, 1.0, communication_step=0.25).contact
        contacts.append((contact.loads, contact.active))
    (loads, active), finer = contacts
    expected = local_errors(loads, active, finer)
    assert stated.shape == expected.shape and expected[active].max() > 1.0
    assert stated == pytest.approx(expected, rel=0.05, abs=1e-6)
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
