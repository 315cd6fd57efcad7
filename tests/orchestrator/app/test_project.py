"""Project folders: what is one, what is inside, and that nothing leads out."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from friction_models.common import InputError
from orchestrator.app.project import FOLDERS, HISTORY, WORK, Project


def test_the_example_is_a_data_set_that_the_commands_read(example: Project) -> None:
    from friction_models import DataSet

    (path,) = example.data_sets()
    data = DataSet.load(path)
    assert data.synthetic
    assert data.tests is not None and set(data.tests["role"]) == {"train", "test"}
    assert all((example.root / name).is_dir() for name in FOLDERS)


def test_a_project_is_opened_again_as_it_was_left(example: Project) -> None:
    (example.root / "data/sct/points.csv").write_text("mine")
    again = Project.open(example.root, example=True)
    assert again.title == example.title
    assert (example.root / "data/sct/points.csv").read_text() == "mine"


def test_a_folder_of_something_else_is_refused_and_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(InputError, match="holds other files"):
        Project.open(tmp_path, example=True)
    assert os.listdir(tmp_path) == ["thesis.tex"]
    with pytest.raises(InputError, match="is a file"):
        Project.open(tmp_path / "thesis.tex")


@pytest.mark.parametrize(
    "text", ["[]", "format: 2", "format: 1\nformat: 1", "a: &a [*a]", "format: 1\ntitle: " + "x" * 200_000]
)
def test_settings_that_are_none_are_a_sentence(tmp_path: Path, text: str) -> None:
    (tmp_path / "project.yaml").write_text(text)
    with pytest.raises(InputError, match=r"project\.yaml"):
        Project.open(tmp_path)


@pytest.mark.parametrize(
    "name",
    [
        "../secret",
        "data/../../secret",
        "/etc/passwd",
        "",
        ".",
        "data//sct",
        "data/./sct",
        f"{WORK}/lock",
        "data/.hidden",
        "data\\..\\secret",
        "data/\x00",
        "data/a\nb",
        "x" * 600,
        "link",
        "link/passwd",
        "data/inner/passwd",
        "loop",
    ],
)
def test_no_path_leads_out_of_the_project(example: Project, name: str, tmp_path: Path) -> None:
    (tmp_path / "secret").touch()
    (example.root / "link").symlink_to("/etc")
    (example.root / "data/inner").symlink_to("/etc")
    (example.root / "loop").symlink_to(example.root / "loop")
    with pytest.raises(InputError, match="leads out of the project"):
        example.inside(name)


def test_paths_inside_are_given(example: Project) -> None:
    assert example.inside("data/sct/points.csv").is_file()
    assert example.inside(HISTORY) == example.root / HISTORY
    (example.root / "short").symlink_to(example.root / "data")
    assert example.inside("short/sct").is_dir()


def test_names_that_a_command_would_take_for_an_option_or_that_lead_out_are_not_listed(
    example: Project,
) -> None:
    for name in ("--force", "a b", "good"):
        folder = example.root / "models" / name
        folder.mkdir()
        (folder / "card.json").write_text("{}")
    (example.root / "models/away").symlink_to("/")
    assert [p.name for p in example.models()] == ["good"]
