"""Examples in docstrings are run: every ``>>>`` of every module of the five packages."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest

PACKAGES = ("friction_models", "forming", "sct_twin", "fmus", "orchestrator")
ROOT = Path(__file__).parents[2]
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def modules_with_examples() -> list[str]:
    """Return the names of all modules whose text holds a docstring example, imported or not."""
    found = []
    for package in PACKAGES:
        for file in sorted((ROOT / package).rglob("*.py")):
            if ">>> " in file.read_text(encoding="utf-8"):
                parts = file.relative_to(ROOT).with_suffix("").parts
                found.append(".".join(parts[:-1] if parts[-1] == "__init__" else parts))
    return found


def examples_of(name: str) -> list[doctest.DocTest]:
    """Return the docstrings of a module that hold examples."""
    module = importlib.import_module(name)
    return [test for test in doctest.DocTestFinder().find(module, name) if test.examples]


#: Without any example one skipped test says so.
NO_EXAMPLE = pytest.param("", marks=pytest.mark.skip(reason="no docstring holds an example"))


@pytest.mark.parametrize("name", modules_with_examples() or [NO_EXAMPLE])
def test_examples_of_docstrings(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    tests = examples_of(name)
    assert tests, f"{name}: holds >>> outside of docstrings that doctest finds"
    said: list[str] = []
    runner = doctest.DocTestRunner(optionflags=FLAGS, verbose=False)
    for test in tests:
        skipped = [e.source for e in test.examples if e.options.get(doctest.SKIP)]
        assert not skipped, f"{test.name}: {skipped} is skipped; an example that does not run shows nothing"
        runner.run(test, out=said.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(said)


def test_a_wrong_example_is_noticed() -> None:
    wrong = doctest.DocTestParser().get_doctest(">>> 1 + 1\n3\n", {}, "wrong", None, 0)
    assert doctest.DocTestRunner(optionflags=FLAGS, verbose=False).run(wrong, out=lambda _: None).failed == 1
