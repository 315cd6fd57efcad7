"""What makes a release: light imports, whole packages, one version, dependencies named once."""

from __future__ import annotations

import fnmatch
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from friction_models.common import InputError
from friction_models.common.imports import extras
from friction_models.common.imports.extras import need
from orchestrator.cli.main import run
from orchestrator.demo import Demo
from tests.friction_models.made_up import campaign

from ..wheel_alone import HEAVY, PACKAGES

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
OWN = PROJECT["project"]
NAME = re.compile(r"[A-Za-z0-9_.-]+")


def names(requirements: list[str]) -> set[str]:
    """Return the lower-case names of requirements."""
    return {NAME.match(r).group().lower().replace("_", "-") for r in requirements}  # type: ignore[union-attr]


def test_importing_the_packages_loads_nothing_heavy() -> None:
    code = (
        f"import sys, friction_models, fmus, orchestrator; print([m for m in {HEAVY!r} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.strip() == "[]"


def test_a_diagnosis_loads_no_library_of_an_extra(tmp_path: Path) -> None:
    libraries = ("numba", "plotly", "pyarrow", "meshio", "pint", "torch", "nicegui")
    code = f"""
import sys
class Refused:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {libraries!r}:
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Refused())
from orchestrator.cli.main import run
sys.exit(run(["diagnose", "--data", "points.csv", "--model", "linear", "--json", "answer.json"]))
"""
    campaign(8, 10).to_csv(tmp_path / "points.csv", index=False)
    own = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, env=own)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "answer.json").is_file()


def test_a_library_that_is_missing_is_named_with_its_extra() -> None:
    need("numpy", "reports", "this")
    with pytest.raises(
        InputError, match=r"^this needs no_such_library.*pip install 'tribofmu\[reports\]' brings it$"
    ):
        need("no_such_library", "reports", "this")


@pytest.mark.parametrize(
    ("library", "extra"), [("numba", "solvers"), ("plotly", "reports"), ("torch", "train-networks")]
)
def test_the_demo_says_before_its_first_step_what_a_later_one_lacks(
    library: str, extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None if name == library else name)
    with pytest.raises(InputError, match=rf"the demo.* needs {library}.*tribofmu\[{extra}\]"):
        Demo(tmp_path / "demo").run()
    assert not (tmp_path / "demo").exists()


def test_every_extra_that_a_sentence_names_is_declared() -> None:
    for package in PACKAGES:
        for file in (ROOT / package).rglob("*.py"):
            text = file.read_text(encoding="utf-8")
            named = re.findall(r"tribofmu\[([a-z-]+)\]", text) + re.findall(
                r'\bneed\("[a-z]+", "([a-z]+)"', text
            )
            assert set(named) <= set(OWN["optional-dependencies"]), file


def test_every_file_of_the_packages_is_package_data() -> None:
    data = PROJECT["tool"]["setuptools"]["package-data"]
    known = subprocess.run(["git", "ls-files", *PACKAGES], cwd=ROOT, capture_output=True, text=True)
    if known.returncode:
        pytest.skip("no git repository")
    for name in known.stdout.split():
        file = Path(name)
        inside = [
            str(file.relative_to(Path(*p.split("."))))
            for p in data
            if p != "*" and name.startswith(p.replace(".", "/") + "/")
        ]
        patterns = [pattern for p in data if p != "*" for pattern in data[p]]
        whole = any(fnmatch.fnmatch(i, pattern) for i in inside for pattern in patterns)
        plain = any(fnmatch.fnmatch(file.name, pattern) for pattern in data["*"])
        assert file.suffix == ".py" or plain or whole, name


def test_version_is_the_same_everywhere() -> None:
    version = OWN["version"]
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"] == version
    assert f"version: {version}\n" in (ROOT / "packaging/conda/recipe.yaml").read_text(encoding="utf-8")
    assert re.search(
        rf"^## \[{re.escape(version)}\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE
    )


def recipe() -> dict[str, Any]:
    """Return the conda recipe, its one variable filled in."""
    text = (ROOT / "packaging/conda/recipe.yaml").read_text(encoding="utf-8")
    return yaml.safe_load(text.replace("${{ version }}", OWN["version"]).replace("${{ PYTHON }}", "python"))


def test_the_conda_recipe_needs_what_the_package_needs_in_the_same_versions() -> None:
    optional = OWN["optional-dependencies"]
    wanted = {
        re.sub(r"[ _]", "-", r.lower())
        for r in [*OWN["dependencies"], *optional["solvers"], *optional["reports"]]
    }
    python = f"python{OWN['requires-python']}"
    needed = recipe()["requirements"]
    # conda-forge has another package by the name of lief: the library alone.
    found = {r.replace(" ", "").lower().replace("py-lief", "lief") for r in needed["run"]}
    assert found == wanted | {python}
    assert {r.replace(" ", "") for r in needed["host"]} == {
        python,
        "pip",
        *PROJECT["build-system"]["requires"],
    }


def test_the_conda_recipe_says_what_pyproject_says_and_names_files_that_are_there() -> None:
    said = recipe()
    assert said["package"] == {"name": OWN["name"], "version": OWN["version"]}
    entries = [f"{name} = {place}" for name, place in OWN["scripts"].items()]
    assert said["build"]["python"]["entry_points"] == entries
    about = said["about"]
    assert (about["license"], about["summary"]) == (OWN["license"], OWN["description"])
    assert (ROOT / about["license_file"]).is_file()
    assert (ROOT / "packaging/conda" / said["source"]["path"]).resolve() == ROOT
    assert set(said["tests"][0]["python"]["imports"]) == set(PACKAGES)


def test_the_commands_by_which_the_conda_package_is_tested_succeed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for line in recipe()["tests"][1]["script"]:
        program, *words = line.split()
        assert program in OWN["scripts"] and run(words) == 0, line


def test_the_image_asks_for_extras_and_files_that_exist() -> None:
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    (asked,) = re.findall(r"\.whl\)\[([a-z,-]+)\]", text)
    assert set(asked.split(",")) <= set(OWN["optional-dependencies"])
    ignored = (ROOT / ".dockerignore").read_text(encoding="utf-8").split()
    for file in (
        *re.findall(r"^COPY (?!--)(\S+) ", text, re.MULTILINE),
        OWN["readme"],
        *OWN["license-files"],
    ):
        assert (ROOT / file).exists() and file not in ignored
    versions = set(re.findall(r"^FROM python:([\d.]+)-slim", text, re.MULTILINE))
    assert len(versions) == 1
    assert f"Programming Language :: Python :: {versions.pop()}" in OWN["classifiers"]
    (program,) = re.findall(r'^ENTRYPOINT \["(\w+)"\]', text, re.MULTILINE)
    assert program in OWN["scripts"]


def test_every_dependency_has_a_version_that_was_tried() -> None:
    pinned = names((ROOT / "constraints.txt").read_text(encoding="utf-8").split())
    optional = OWN["optional-dependencies"]
    every = names([*OWN["dependencies"], *(r for requirements in optional.values() for r in requirements)])
    assert every - {"tribofmu"} <= pinned
