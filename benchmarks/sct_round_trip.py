"""The twin against the truth of virtual campaigns: errors of the loads by punch, time of 222 twins, memory of a worker."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from friction_models.common.processes.pool import default_jobs
from sct_twin import SctTwin
from sct_twin.ingest.campaign_files import ingest
from sct_twin.virtual_lab import Campaign, load_truth
from tests.round_trip import deviations

from .common import Section, Table, section
from .data import PLAN, sources

#: Lubricant, hidden effect, seed and file format of each campaign: a plain rig, and rigs with flaws.
CAMPAIGNS: tuple[tuple[str | None, str | None, int, str], ...] = (
    (None, "stribeck", 1, "canonical"),
    ("polymer", None, 2, "mdf"),
    ("mos2", None, 3, "catman"),
)
#: Bars [%]; the share of points within two stated uncertainties of mu.
BARS = {"T": 3.0, "sigma_n": 2.0, "psi": 3.0}


def measure(folder: Path) -> Section:
    """Run the campaigns through files, ingest and twin; compare with the truth, and take the time."""
    errors, times = [], Table(["what", "value"])
    wall = 0.0
    for number, (lubricant, hidden, seed, file_format) in enumerate(CAMPAIGNS):
        place = folder / "round-trip" / sources("sct_twin", "forming") / f"{lubricant or 'plain'}-{seed}"
        if not (place / "campaign" / "campaign.json").is_file():
            lab = Campaign(plan=PLAN, hidden=hidden, seed=seed, lubricant=lubricant)
            lab.write(place / "lab", file_format)
            mapped = place / "lab" / "channels.yaml"
            ingest(place / "lab", mapped if mapped.is_file() else None, place / "campaign")
        shutil.rmtree(place / "data", ignore_errors=True)
        began = time.perf_counter()
        data = SctTwin().run(place / "campaign", out=place / "data").dataset()
        if number < 2:
            wall += time.perf_counter() - began
        found = deviations(data, load_truth(place / "lab")[1])
        assert data.tests is not None
        found = found.merge(data.tests[["test_id", "psi_set", "sigma_set"]], on="test_id")
        errors.append(found.assign(rig=lubricant or "plain"))
    everything = pd.concat(errors, ignore_index=True)
    jobs = default_jobs()
    times.rows.append(
        (f"twins of two campaigns, 222 tests, {jobs} processes, files and starts included", f"{wall:.0f} s")
    )
    single, memory = one_worker(place / "campaign")
    times.rows.append(("one twin, one core, median over 20 tests of all punches", f"{single:.2f} s"))
    times.rows.append(("peak memory of a process that ran them", f"{memory:.0f} MB"))
    return section(
        "Round trip of compression tests",
        "Raw files of virtual campaigns (111 tests each; plain rig in canonical CSV, rig with flaws and polymer in MDF, with MoS2 in "
        "catman binary), ingested, through the twin, against the laboratory's truth, which is made with another mesh, grid, "
        "material, heat data and friction while upsetting. Errors of the means over the sliding: T in % of the rise over the tool.",
        by_rig(everything),
        by_punch(everything),
        worst(everything),
        times,
    )


def by_rig(errors: pd.DataFrame) -> Table:
    """Return standard deviation, largest error and tests outside the bars, and how mu keeps its uncertainty."""
    table = Table(
        [
            "rig",
            "tests",
            *(f"{k}: std / worst [%]" for k in BARS),
            "outside a bar",
            "mu RMS",
            "mu stated",
            "within 2 stated",
        ]
    )
    for rig, rows in errors.groupby("rig", sort=False):
        outside = np.logical_or.reduce([rows[k].abs() > bar for k, bar in BARS.items()])
        table.rows.append(
            (
                rig,
                len(rows),
                *(_spread(rows[k]) for k in BARS),
                int(outside.sum()),
                f"{np.sqrt((rows['mu_rms'] ** 2).mean()):.5f}",
                f"{np.sqrt((rows['mu_std'] ** 2).mean()):.5f}",
                f"{100 * rows['mu_inside'].mean():.0f} %",
            )
        )
    return table


def by_punch(errors: pd.DataFrame) -> Table:
    """Return the errors by area ratio of the punch."""
    table = Table(["area ratio of the plan", "tests", *(f"{k}: std / worst [%]" for k in BARS)])
    for ratio, rows in errors.groupby("psi_set"):
        table.rows.append((f"{ratio:g}", len(rows), *(_spread(rows[k]) for k in BARS)))
    return table


def worst(errors: pd.DataFrame, count: int = 6) -> Table:
    """Return the tests that come nearest to a bar or miss it."""
    share = np.maximum.reduce([errors[k].abs() / bar for k, bar in BARS.items()])
    table = Table(["test", "rig", "sigma_set", "area ratio", *(f"{k} [%]" for k in BARS)])
    for row in errors.assign(share=share).nlargest(count, "share").to_dict("records"):
        head = (row["test_id"], row["rig"], f"{row['sigma_set']:g}", f"{row['psi_set']:g}")
        table.rows.append((*head, *(f"{row[k]:+.1f}" for k in BARS)))
    return table


def _spread(values: pd.Series[Any]) -> str:
    return f"{values.std():.1f} / {values.abs().max():.1f}"


def one_worker(campaign: Path) -> tuple[float, float]:
    """Return median time of one twin [s] and peak memory [MB] of a fresh process that runs 20 tests one by one."""
    command = [sys.executable, "-m", "benchmarks.sct_worker", str(campaign)]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    seconds, memory = said.split()
    return float(seconds), float(memory)
