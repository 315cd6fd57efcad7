"""What a command may write to: its own kind of folder, an empty one, a new one; never what it reads."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from friction_models import LinearFriction
from friction_models.common import InputError
from friction_models.common.locks import locked
from friction_models.loads import DataSet
from orchestrator.cli.main import run
from tests.orchestrator.cli.test_command_line import points
from tests.orchestrator.tiny_fmus import write_system


def contents(folder: Path) -> dict[str, str]:
    """Names of everything in a folder, with hashes of files and targets of links."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_symlink():
            found[str(path)] = f"-> {os.readlink(path)}"
        elif path.is_file():
            found[str(path)] = hashlib.md5(path.read_bytes()).hexdigest()
        else:
            found[str(path)] = "folder"
    return found


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, tiny: dict[str, Path]) -> Path:
    """A user's folder: data, a model, a system, a campaign, press curves, a thesis."""
    folder = tmp_path_factory.mktemp("made") / "project"
    folder.mkdir()
    frame = points(3, 12)
    roles = pd.DataFrame({"test_id": ["t0", "t1", "t2"], "role": ["train", "train", "test"]})
    DataSet(frame, roles, {"synthetic": True}).save(folder / "data")
    LinearFriction().fit_frame(frame).save(folder / "linear")
    write_system(folder, tiny)
    (folder / "thesis").mkdir()
    (folder / "thesis" / "thesis.tex").write_text("three years of work")
    (folder / "press").mkdir()
    (folder / "press" / "a.csv").write_text("stroke [mm],force [kN]\n0,0\n1,10\n")
    (folder / "press" / "levels.csv").write_text("process,T_tool,speed,lubricant,file\nfre,20,5,oil,a.csv\n")
    (folder / "campaign" / "raw").mkdir(parents=True)
    (folder / "campaign" / "campaign.json").write_text('{"format": "sct-campaign", "version": 1}')
    (folder / "campaign" / "tests.csv").write_text("test_id\nx\n")
    (folder / "raw").mkdir()
    (folder / "raw" / "x.csv").write_text("t [s],F_n [N]\n0,1\n")
    return folder


@pytest.fixture
def place(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the user's folder, the current folder."""
    folder = tmp_path / "project"
    shutil.copytree(made, folder)
    monkeypatch.chdir(folder)
    return folder


#: Every command that writes a folder; OUT stands for it.
FOLDERS = {
    "simulate": "simulate system.yaml -o OUT",
    "lab": "lab --plan reduced-27 -o OUT",
    "ingest": "ingest raw -o OUT",
    "points": "points data -o OUT",
    "twin": "twin campaign -o OUT",
    "train": "train linear --data data -o OUT",
    "refine": "refine --data data --model linear --add stribeck -o OUT",
    "predict-sct": "predict-sct 0.08 --data data -o OUT",
    "pack c": "pack linear --target c -o OUT",
    "pack ufric": "pack linear --target ufric -o OUT",
    "pack vfric": "pack linear --target vfric -o OUT",
    "pack deform": "pack linear --target deform -o OUT",
    "pack lsdyna": "pack linear --target lsdyna -o OUT",
    "pack qform": "pack linear --target qform -o OUT",
    "pack abaqus": "pack linear --target abaqus -o OUT",
    "pack radioss": "pack linear --target radioss -o OUT",
    "pack calculix": "pack linear --target calculix -o OUT",
    "pack table": "pack linear --target table -o OUT",
    "demo": "demo -o OUT",
    "compare": "compare --models 0.08 --press press --runs OUT",
    "attribute": "attribute --press press --system system.yaml --runs OUT",
    "study learning-curve": "study learning-curve --quick -o OUT",
    "study forming-error": "study forming-error --quick -o OUT",
    "study lag": "study lag --quick -o OUT",
    "study extrapolation": "study extrapolation --quick -o OUT",
}
TARGETS = {
    "a folder of other things": "thesis",
    "the project": ".",
    "its parent": "..",
    "a file": "thesis/thesis.tex",
    "below a file": "thesis/thesis.tex/out",
    "a name too long": "x" * 300,
    "a model's neighbour": "mixed",
}


@pytest.mark.parametrize("words", FOLDERS.values(), ids=FOLDERS)
@pytest.mark.parametrize("target", TARGETS.values(), ids=TARGETS)
def test_no_command_replaces_what_it_did_not_make(
    place: Path, words: str, target: str, capsys: pytest.CaptureFixture[str]
) -> None:
    # A folder with all our marks, and something of the user's: nothing in it may be lost.
    (place / "mixed").mkdir()
    for name in ("manifest.json", "results.nc", "card.json", "model.onnx", "campaign.json", "export.json"):
        (place / "mixed" / name).write_text("{}")
    (place / "mixed" / "notes.txt").write_text("mine")
    before = contents(place.parent)
    assert run(words.replace("OUT", target).split()) == 2
    said = capsys.readouterr().err
    assert said.startswith("tribofmu: error: ") and len(said.splitlines()) == 1
    assert target[:40] in said
    assert contents(place.parent) == before


@pytest.mark.parametrize("words", [w for n, w in FOLDERS.items() if n in {"simulate", "train", "pack c"}])
def test_new_empty_and_own_folders_are_written(place: Path, words: str) -> None:
    (place / "empty").mkdir()
    for target in ("new/below", "new/below", "empty", "empty"):
        assert run(words.replace("OUT", target).split()) == 0
    own = place / "new" / "below"
    whole = contents(own)
    (own / "notes.txt").write_text("mine")
    assert run(words.replace("OUT", "new/below").split()) == 2
    (own / "notes.txt").unlink()
    assert contents(own) == whole


def test_links_are_not_replaced(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["train", "linear", "--data", "data", "-o", "real"]) == 0
    for name, to in (("link", "real"), ("dangling", "nowhere"), ("other", "thesis")):
        (place / name).symlink_to(to)
        before = contents(place)
        capsys.readouterr()
        assert run(["train", "linear", "--data", "data", "-o", name]) == 2
        assert f"{name}: is a link" in capsys.readouterr().err
        assert contents(place) == before
    # A folder reached through a link is a folder.
    (place / "disk").mkdir()
    (place / "runs").symlink_to("disk")
    assert run(["train", "linear", "--data", "data", "-o", "runs/linear"]) == 0
    assert (place / "disk" / "linear" / "card.json").is_file()


@pytest.mark.parametrize(
    "words",
    [
        "predict linear --data points.csv -o points.csv",
        "predict linear --data data -o data/points.csv",
        "predict linear --data data --tests tests.csv -o ./tests.csv",
        "evaluate linear --data data --json linear/card.json",
        "evaluate linear --data data --json data/../points.csv --tests points.csv",
        "pack model.onnx --spec spec.yaml -o model.onnx",
        "pack linear -o linear",
        "export system.yaml --swap friction=other.fmu -o other.fmu",
        "export system.yaml -o law.fmu",
        "export system.yaml -o system.yaml",
        "simulate run/system.yaml -o run",
        "simulate system.yaml --swap friction=run/law.fmu -o run",
        "simulate system.yaml --press run/press.csv -o run",
        "twin campaign -o campaign",
        "ingest campaign -o campaign",
        "ingest campaign/raw -o campaign",
        "ingest campaign --map campaign/map.yaml -o campaign",
        "train linear --data data -o data",
        "refine --data data --model linear --add stribeck -o linear",
        "lab --plan plan.csv -o .",
        "compare --models linear 0.08 --data data --json points.csv --tests points.csv",
        "compare --models law.fmu --data data --report law.fmu",
        "coverage --data data --history points.csv --report points.csv",
        "coverage --data data --history points.csv --plan points.csv",
        "diagnose --data data --model model.onnx --report model.onnx",
        "attribute --press press --system system.yaml --json system.yaml",
        "attribute --press press --system system.yaml --report process.fmu",
        "attribute --press press --system system.yaml --json press/a.csv",
        "study lag --data oil=data -o data",
        "evaluate linear --data data --json same.json --names same.json",
        "verify --json same.out -o same.out",
    ],
)
def test_no_output_overwrites_an_input(place: Path, words: str, capsys: pytest.CaptureFixture[str]) -> None:
    points(2, 12).to_csv(place / "points.csv", index=False)
    for name in ("tests.csv", "model.onnx", "other.fmu", "spec.yaml", "plan.csv", "same.json"):
        (place / name).write_text("something of the user's")
    (place / "campaign" / "map.yaml").write_text("channels: {}")
    (place / "run").mkdir()
    for name in ("manifest.json", "results.nc", "system.yaml", "law.fmu", "press.csv"):
        (place / "run" / name).write_bytes((place / "law.fmu").read_bytes())
    (place / "run" / "system.yaml").write_bytes((place / "system.yaml").read_bytes())
    before = contents(place)
    assert run(words.split()) == 2
    said = capsys.readouterr().err
    assert said.startswith("tribofmu: error: ") and len(said.splitlines()) == 1
    assert contents(place) == before
    told = ("input of this command", "two outputs of one name", "suffix '.fmu'; allowed: .html")
    assert any(words in said for words in told)


def test_reports_and_results_may_lie_beside_what_they_are_about(place: Path) -> None:
    for _ in range(2):
        assert run(["evaluate", "linear", "--data", "data", "--json", "linear/errors.json"]) == 0
        assert run(["predict", "linear", "--data", "data", "-o", "data/predicted.csv"]) == 0


def test_a_command_that_fails_leaves_no_folders_above_its_output(place: Path) -> None:
    before = contents(place)
    (place / "raw" / "y.csv").write_text("a,b\n1,2\n")
    assert run(["ingest", "raw/y.csv", "-o", "here/and/there"]) == 2
    (place / "raw" / "y.csv").unlink()
    assert contents(place) == before


def test_a_way_through_a_link_is_the_way_of_the_system(place: Path, tmp_path: Path) -> None:
    """``link/..`` is the folder above that which the link names, not the one that the link lies in."""
    elsewhere = tmp_path / "elsewhere"
    (elsewhere / "dir").mkdir(parents=True)
    (elsewhere / "campaign").mkdir()
    (elsewhere / "campaign" / "points.csv").write_text("a user's")
    (place / "link").symlink_to(elsewhere / "dir")
    before = contents(tmp_path)
    assert run(["twin", "campaign", "-o", "link/../campaign"]) == 2
    assert contents(tmp_path) == before
    whole = contents(place)
    assert (
        run(
            [
                "refine",
                "--data",
                "data",
                "--model",
                "linear",
                "--add",
                "stribeck",
                "--force",
                "-o",
                "link/../linear",
            ]
        )
        == 0
    )
    assert contents(place) == whole and (elsewhere / "linear" / "card.json").is_file()


def test_what_a_user_put_deeper_into_our_folder_is_not_lost(place: Path) -> None:
    assert run(["simulate", "system.yaml", "-o", "own"]) == 0
    for name in ("fields/mine.txt", "fmus/mine.fmu", "thoughts"):
        mine = place / "own" / name
        mine.parent.mkdir(exist_ok=True)
        if mine.suffix:
            mine.write_text("mine")
        else:
            mine.mkdir()
        before = contents(place)
        assert run(["simulate", "system.yaml", "-o", "own"]) == 2, name
        assert contents(place) == before
        if mine.suffix:
            mine.unlink()
            if not any(mine.parent.iterdir()):
                mine.parent.rmdir()
        else:
            mine.rmdir()
    assert run(["simulate", "system.yaml", "-o", "own"]) == 0


def test_names_alone_do_not_make_a_folder_ours(place: Path) -> None:
    (place / "theirs").mkdir()
    for name in ("manifest.json", "results.nc", "report.html"):
        (place / "theirs" / name).write_text('{"my": "manifest"}')
    before = contents(place)
    assert run(["simulate", "system.yaml", "-o", "theirs"]) == 2
    assert contents(place) == before


def test_an_unfinished_campaign_takes_no_folder_of_the_user(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (place / ".c.partial").mkdir()
    (place / ".c.partial" / "mine.txt").write_text("precious")
    before = contents(place)
    assert run(["lab", "--plan", "reduced-27", "-o", "c"]) == 2
    assert ".c.partial" in capsys.readouterr().err
    assert contents(place) == before
    with (
        locked(place / "lock", "busy"),
        pytest.raises(InputError, match="busy"),
        locked(place / "lock", "busy"),
    ):
        pass


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
def test_a_mark_that_is_no_file_is_not_waited_for(place: Path) -> None:
    (place / "grown" / "twin").mkdir(parents=True)
    (place / "grown" / "twin" / "x.nc").write_text("")
    os.mkfifo(place / "grown" / ".tribofmu")
    assert run(["twin", "campaign", "-o", "grown"]) == 2


def test_who_reads_the_first_lines_only_gets_the_files(tmp_path: Path) -> None:
    """`diagnose --report FILE | head -3` wrote no report, in silence."""
    done = tmp_path / "done"
    code = f"""
from pathlib import Path
from orchestrator.cli.common.console import say
for k in range(3):
    say(str(k))
Path({str(done)!r}).write_text("all")
"""
    unread, pipe = os.pipe()
    os.close(unread)
    try:
        ran = subprocess.run(
            [sys.executable, "-c", code], stdout=pipe, stderr=subprocess.PIPE, timeout=120, check=False
        )
    finally:
        os.close(pipe)
    assert (ran.returncode, ran.stderr) == (0, b"") and done.read_text() == "all"
