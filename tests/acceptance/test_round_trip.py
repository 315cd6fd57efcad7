"""Round trip by the command line: raw files of the virtual laboratory -> ingest -> twin -> loads near the laboratory's truth.

The truth is made with another mesh, another grid, other material and heat data and another friction while
upsetting than the twin assumes; it lies in files that no command of the chain reads. All data is synthetic.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from friction_models.loads import DataSet
from sct_twin.virtual_lab import FORMATS, load_truth
from tests.round_trip import deviations

Tribofmu = Callable[..., str]
#: Packages without which a format cannot be written or read.
NEEDED = {"mdf": "asammdf", "tdms": "nptdms"}
#: Flat, cup and reduced first contact; fast and cold, slow, hot, and so slow that the plate sticks and jumps first.
PLAN = """protocol,sigma_set,psi_set,v_set,T_tool,sd_set
constant,1750,1.069,500,20,25
constant,2750,5,50,100,12
constant,800,20,200,300,18
constant,2750,1.069,5,20,8
"""


@pytest.mark.slow
@pytest.mark.parametrize("file_format", FORMATS)
def test_loads_come_back_from_every_format(file_format: str, tribofmu: Tribofmu, tmp_path: Path) -> None:
    if file_format in NEEDED:
        pytest.importorskip(NEEDED[file_format])
    lab, campaign, data = (tmp_path / name for name in ("lab", "campaign", "data"))
    tests = 4 if file_format == "canonical" else 1  # a format changes nothing in the loads
    plan = tmp_path / "plan.csv"
    plan.write_text("".join(PLAN.splitlines(keepends=True)[: 1 + tests]))
    options = ["--plan", plan, "--lubricant", "polymer", "--seed", 5, "--jobs", 1]
    assert "synthetic" in tribofmu("lab", *options, "--format", file_format, "-o", lab)
    mapped = ["--map", lab / "channels.yaml"] if (lab / "channels.yaml").is_file() else []
    assert (file_format == "canonical") == (not mapped)
    assert f"{tests} test" in tribofmu("ingest", lab, *mapped, "-o", campaign)
    assert not list(campaign.glob("truth*"))
    assert "synthetic data set" in tribofmu("twin", campaign, "-o", data, "--jobs", 1)
    found = deviations(DataSet.load(data), load_truth(lab)[1])
    assert len(found) == tests
    said = found.round(4).to_string()
    assert (found["T"].abs() < 3.0).all(), said  # % of the mean rise
    assert (found["sigma_n"].abs() < 2.0).all(), said
    assert (found["psi"].abs() < 3.0).all(), said
    assert (found["mu_inside"] > 0.9).all(), said  # share of points within two stated standard uncertainties
    assert (found["mu_rms"] < 0.0025).all(), said
    assert np.isfinite(found["mu_std"]).all() and (found["mu_std"] < 0.002).all(), said
