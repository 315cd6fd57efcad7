"""``python -m benchmarks.workbench``: processor time to open a million points in the workbench, step by step, without the browser."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd

from friction_models.loads import DataSet
from orchestrator.app.explore_figures import cloud, sample
from orchestrator.app.map_form import MapForm
from orchestrator.app.project import Project
from orchestrator.app.raw_figures import columns_figure, loads_figure
from orchestrator.app.raw_files import raw_set, read_once
from sct_twin.ingest.point_tables import read_point_tables

from .common import Table

T = TypeVar("T")
POINTS, TESTS = 1_000_000, 200


def table_of_points(seed: int = 1) -> pd.DataFrame:
    """Return made-up points of many tests."""
    draw, each = np.random.default_rng(seed), POINTS // TESTS
    return pd.DataFrame(
        {
            "test_id": np.repeat([f"t{k:03d}" for k in range(TESTS)], each),
            "v_rel": np.repeat(draw.uniform(5.0, 500.0, TESTS), each).round(3),
            "T": draw.uniform(20.0, 200.0, POINTS).round(2),
            "sigma_n": draw.uniform(100.0, 900.0, POINTS).round(2),
            "sd": np.tile(np.linspace(0.0, 80.0, each), TESTS).round(4),
            "psi": np.repeat(draw.uniform(0.5, 2.0, TESTS), each).round(3),
            "mu": draw.uniform(0.03, 0.12, POINTS).round(5),
        }
    )


def measure(folder: Path) -> Table:
    """Time the steps of the pages Explore and Measurements [s of the processor]."""
    project = Project.open(folder / "project")
    points = table_of_points()
    for place in ("data/big/points.csv", "raw/big/big.csv"):
        (project.root / place).parent.mkdir()
        points.to_csv(project.root / place, index=False)
    found = Table(["step", "processor time [s]"])

    def step(name: str, work: Callable[[], T]) -> T:
        began = time.process_time()
        result = work()
        found.rows.append((name, f"{time.process_time() - began:.2f}"))
        return result

    data = step("Explore: read the data set", lambda: DataSet.load(project.root / "data/big", need_mu=False))
    drawn = step("Explore: thin", lambda: sample(data))
    step("Explore: draw", lambda: cloud(drawn, "sd", "mu", "v_rel", lines=True))
    raw = step("Map: read the file", lambda: raw_set(project, "big"))
    assert raw.first is not None
    table = raw.first
    form = MapForm.of(table, False, {})
    files = [project.inside(f) for f in raw.files]
    tables = step("Map: make the points", lambda: read_point_tables(files, form.content(), read=read_once))
    step("Map: draw the points", lambda: loads_figure(tables.dataset.points))
    step("Map: draw the columns", lambda: columns_figure(form, table, None))
    return found


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        print("\n".join(measure(Path(folder)).lines()))


if __name__ == "__main__":
    main()
