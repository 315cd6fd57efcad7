"""The notebook of the examples, run cell by cell as a notebook runs it."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any

import plotly.graph_objects as go
import pytest

NOTEBOOK = Path(__file__).parents[2] / "examples" / "your_own_tests.ipynb"
MOST_LINES, FIGURES = 25, 6


def cells() -> list[str]:
    content = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    return ["".join(c["source"]) for c in content["cells"] if c["cell_type"] == "code"]


def shown_by(cell: str, names: dict[str, Any]) -> Any:
    """Run a cell; return the value of its last expression, which a notebook shows."""
    tree = ast.parse(cell)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, str(NOTEBOOK), "exec"), names)
    if last is None:
        return None
    return eval(compile(ast.Expression(last.value), str(NOTEBOOK), "eval"), names)  # noqa: S307


def test_the_whole_loop_on_a_table_in_few_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    lines = [line for cell in cells() for line in cell.splitlines() if line.strip()]
    assert len(lines) <= MOST_LINES
    names: dict[str, Any] = {}
    shown = [shown_by(cell, names) for cell in cells()]
    figures = [s for s in shown if isinstance(s, go.Figure)]
    assert len(figures) >= FIGURES and all(f.data for f in figures)
    diagnosis = names["diagnosis"]
    assert diagnosis.effects and len(repr(diagnosis)) < 200
    assert diagnosis.sentence.split(":")[0] in diagnosis._repr_html_()
    errors = names["after"].error_history_[-1]
    assert errors["after"]["rmse"] < errors["before"]["rmse"]
    assert names["run"].complete and names["run"]["forming.force"].max() > 50.0
