"""Time of the twin and of the diagnosis on a full campaign."""

from __future__ import annotations

import time
from pathlib import Path

from friction_models.discovery import diagnose
from sct_twin import SctTwin
from sct_twin.ingest.raw_campaign import RawCampaign

from .common import Section, Table, section
from .data import campaign, raw_folder


def measure(folder: Path) -> Section:
    """Time single tests of the twin, and the diagnosis of 81 and 111 tests."""
    data = campaign(folder, "stribeck", 1)
    raw = RawCampaign.load(raw_folder(folder, "stribeck", 1))
    twin = SctTwin()
    table = Table(["step", "time [s]"])
    tests = raw.tests.drop_duplicates("v_set").head(3)
    twin.evaluate(raw.record(str(tests["test_id"].iloc[0])), raw.moving_mass)  # compiles, or loads
    for test_id, speed in zip(tests["test_id"], tests["v_set"]):
        record = raw.record(str(test_id))
        began = time.perf_counter()
        twin.evaluate(record, raw.moving_mass)
        table.rows.append((f"twin of one test at {speed:g} mm/s", f"{time.perf_counter() - began:.2f}"))
    for name, part in (("81 training tests", data.select("train")), ("all 111 tests", data)):
        began = time.perf_counter()
        diagnose(part.points, part.tests, model="linear")
        table.rows.append((f"diagnosis of {name}", f"{time.perf_counter() - began:.2f}"))
    return section("Twin and diagnosis", "One core, without compilation.", table)
