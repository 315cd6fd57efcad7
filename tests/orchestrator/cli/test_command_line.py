"""The command line: help, exit codes, one sentence for every kind of bad input, nothing half-written."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models import LinearFriction
from friction_models.common import InputError
from friction_models.common.json_values import plain
from friction_models.loads import DataSet
from orchestrator.cli.common.console import keeping, progress
from orchestrator.cli.common.options import key_values
from orchestrator.cli.main import run, spread

COMMANDS = [
    "demo",
    "lab",
    "ingest",
    "points",
    "tests",
    "twin",
    "train",
    "evaluate",
    "predict",
    "pack",
    "check",
    "simulate",
    "compare",
    "diagnose",
    "refine",
    "report",
    "story",
    "app",
]
Check = Callable[..., str]


def points(tests: int = 6, n: int = 30, seed: int = 0) -> pd.DataFrame:
    rng = np.random.default_rng(seed)
    parts = []
    for k in range(tests):
        sd = np.linspace(0.1, 20.0, n)
        v, T, sigma = rng.uniform(5, 500), rng.uniform(20, 300), rng.uniform(500, 2500)
        mu = 0.09 - 4e-5 * v - 2e-5 * T - 5e-6 * sigma + 1e-4 * sd + 0.002 * rng.standard_normal()
        parts.append(
            pd.DataFrame(
                {
                    "test_id": f"t{k}", "t": sd / v, "v_rel": v, "T": T + sd, "sigma_n": sigma, "sd": sd,
                    "psi": rng.uniform(1.0, 1.8), "mu": mu + 3e-4 * rng.standard_normal(n),
                }
            )
        )  # fmt: skip
    return pd.concat(parts, ignore_index=True)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a data set and a trained model."""
    folder = tmp_path_factory.mktemp("cli")
    frame = points()
    roles = pd.DataFrame({"test_id": [f"t{k}" for k in range(6)], "role": ["train"] * 4 + ["test"] * 2})
    DataSet(frame, roles, {"synthetic": True}).save(folder / "data")
    LinearFriction().fit_frame(frame).save(folder / "linear")
    return folder


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Check:
    """Run a command that must fail with exit code 2 and one sentence, writing nothing."""

    def check(*arguments: object) -> str:
        before = sorted(tmp_path.rglob("*"))
        code = run([str(a) for a in arguments])
        error = capsys.readouterr().err
        assert code == 2, error
        assert "Traceback" not in error
        assert error.startswith("tribofmu: error: ")
        assert len(error.strip().splitlines()) == 1, error
        assert sorted(tmp_path.rglob("*")) == before
        return error

    return check


def broken(tmp_path: Path, change: Callable[[pd.DataFrame], pd.DataFrame]) -> Path:
    path = tmp_path / "points.csv"
    change(points(2)).to_csv(path, index=False)
    return path


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([command, "--help"]) == 0
    assert f"tribofmu {command}" in capsys.readouterr().out.replace("\n", " ")


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys; from orchestrator.cli.main import run; run(['--help']);"
        "heavy = {'nicegui', 'numpy', 'pandas', 'torch', 'sklearn', 'xarray', 'plotly', 'numba', 'fmpy', 'onnxruntime'};"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"
    assert all(command in done.stdout for command in COMMANDS)


def test_what_runs_fmus_loads_neither_pandas_nor_scikit_learn() -> None:
    code = (
        "import sys, fmus.checks.trial, fmus.runtime.foreign_friction, fmus.targets.packing, orchestrator.cosim.master;"
        "import friction_models.models.onnx_model;"
        "print(sorted({'pandas', 'sklearn', 'scipy', 'xarray'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_letters_that_the_console_lacks_end_no_command(tmp_path: Path) -> None:
    (tmp_path / "tests.csv").write_text("test_id,operator\nt1,M\u00fcller\n", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", "from orchestrator.cli import main; main()", "tests", str(tmp_path)],
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert b"M\\xfcller" in done.stdout


#: Sets the title of a terminal's window.
TITLE = "\x1b]0;evil\x07"


def test_what_files_say_is_no_markup_and_no_command_of_the_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for terminal in (True, False):
        monkeypatch.setattr(sys.stderr, "isatty", lambda terminal=terminal: terminal)
        with progress(f"rod [/red]{TITLE}") as tick:
            tick(1, 1, f"test [/bold]{TITLE}")
        shown = capsys.readouterr().err
        assert (
            "rod [/red]" in shown and "test [/bold]" in shown and "\x1b]" not in shown and "\x07" not in shown
        )


def test_names_in_a_table_are_no_commands_of_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "points.csv").write_text(f"mu,v{TITLE}\n0.1,1\n", encoding="utf-8")
    assert run(["points", str(tmp_path / "points.csv"), "--dry-run"]) == 0
    said = "".join(capsys.readouterr())
    assert "evil" in said and "\x1b]" not in said and "\x07" not in said


@pytest.mark.parametrize(
    "words",
    [
        ["train", "linear"],
        ["diagnose", "--model", "linear"],
        ["refine", "--model", "linear", "--add", "viscous"],
    ],
)
@pytest.mark.parametrize("role", ["test", "foo"])
def test_tests_that_are_all_held_out_train_nothing(
    role: str, words: list[str], refused: Check, tmp_path: Path
) -> None:
    roles = pd.DataFrame({"test_id": [f"t{k}" for k in range(6)], "role": role})
    DataSet(points(), roles, {"synthetic": True}).save(tmp_path / "data")
    out = [] if words[0] == "diagnose" else ["-o", tmp_path / "model"]
    said = refused(*words, "--data", tmp_path / "data", *out)
    assert f"{tmp_path / 'data'}: no test has the role 'train', the table holds {role}; allowed" in said


def test_a_file_that_is_no_model_is_not_proposed_as_one(refused: Check, place: Path) -> None:
    file = place / "data" / "points.csv"
    assert "did you mean" not in refused("evaluate", file, "--data", place / "data")
    near = file.with_name("point.csv")
    assert f"did you mean '{file}'?" in refused("evaluate", near, "--data", place / "data")


@pytest.mark.usefixtures("built_anew")
def test_a_full_folder_of_temporary_files_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("fmus.native.compile.Path.write_text", full)
    assert run(["pack", "0.1", "-o", str(tmp_path / "a.fmu")]) == 1
    said = capsys.readouterr().err
    assert f"No space left on device, maybe for temporary files in {tmp_path}" in said
    assert "OSError" not in said


def test_several_values_of_one_option() -> None:
    assert spread(["compare", "--models", "a", "b", "--data", "d"]) == [
        "compare", "--models", "a", "--models", "b", "--data", "d",
    ]  # fmt: skip
    assert spread(["train", "linear", "--data", "d"]) == ["train", "linear", "--data", "d"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f[["test_id", "t", "mu"]], ["points.csv", "'v_rel'", "missing"]),
        (lambda f: f.rename(columns={"sigma_n": "sigma"}), ["'sigma_n'", "is it 'sigma'"]),
        (lambda f: f.rename(columns={"T": "T [MPa]"}), ["'T'", "'MPa'", "allowed: K, degC, degF"]),
        (lambda f: f.assign(mu=f["mu"].where(f.index % 7 != 6)), ["'mu'", "row 6", "8 of 60 points", "10%"]),
        (lambda f: f.assign(t=f["t"].iloc[::-1].to_numpy()), ["'t'", "row 1", "must not run backwards"]),
        (lambda f: f.assign(v_rel=-f["v_rel"]), ["'v_rel'", "row 0", "0 to 100000 mm/s"]),
        (lambda f: f.assign(psi="much"), ["'psi'", "'much'", "not a number"]),
    ],
)  # fmt: skip
def test_bad_tables(
    refused: Check,
    tmp_path: Path,
    change: Callable[[pd.DataFrame], pd.DataFrame],
    words: list[str],
) -> None:
    path = broken(tmp_path, change)
    said = refused("train", "linear", "--data", path, "-o", tmp_path / "model")
    assert all(word in said for word in words), said


def test_an_empty_file_and_no_file(refused: Check, tmp_path: Path) -> None:
    empty = tmp_path / "points.csv"
    empty.write_text("")
    assert "empty" in refused("train", "linear", "--data", empty, "-o", tmp_path / "model")
    assert "no such file" in refused("train", "linear", "--data", tmp_path / "no.csv", "-o", tmp_path / "m")
    assert "no points.csv" in refused("diagnose", "--data", tmp_path / "..", "--model", "linear")


def test_misspelt_names_get_the_nearest(refused: Check, place: Path, tmp_path: Path) -> None:
    data = place / "data"
    assert "did you mean 'linear'" in refused("train", "liner", "--data", data, "-o", tmp_path / "m")
    assert "did you mean 'polynomial'" in refused("diagnose", "--data", data, "--model", "polynomal")
    said = refused(
        "refine", "--data", data, "--model", place / "linear", "--add", "stribek", "-o", tmp_path / "m"
    )
    assert "did you mean 'stribeck'" in said
    assert "did you mean 'stribeck'" in refused("lab", "--hidden", "stribbeck", "-o", tmp_path / "c")
    assert "factorial-81" in refused("lab", "--plan", "factorial-80", "-o", tmp_path / "c")
    said = refused("train", "polynomial", "--data", data, "--set", "degre=2", "-o", tmp_path / "m")
    assert "did you mean 'degree'" in said
    assert "did you mean 'native'" in refused(
        "pack", place / "linear", "--target", "nativ", "-o", tmp_path / "f.fmu"
    )
    said = refused("pack", place / "linear", "--target", "process", "-o", tmp_path / "f.fmu")
    assert "unknown target 'process'; allowed: abaqus, c, " in said and "did you mean" not in said
    assert "no such model" in refused("evaluate", tmp_path / "gone", "--data", data)
    assert f"did you mean '{place / 'linear'}'" in refused("evaluate", place / "linar", "--data", data)
    assert "did you mean 'process'" in refused(
        "pack", "forming", "--set", "proces=ring", "-o", tmp_path / "f.fmu"
    )
    assert "name of a family" in refused("evaluate", "linear", "--data", data)


def test_where_trained_models_are_taken_no_family_is_offered(refused: Check, place: Path) -> None:
    for words in (["evaluate", "nosuch"], ["compare", "--models", "nosuch"]):
        said = refused(*words, "--data", place / "data")
        assert (
            "nosuch: no such model; allowed: a model folder, an .fmu or .onnx file, card:NAME or a number"
            in said
        )
    assert "allowed: constant, ffnn" in refused("diagnose", "--model", "nosuch", "--data", place / "data")


def test_a_folder_without_a_model_or_data_is_named(
    refused: Check, place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in (".", ""):
        assert ".: no card.json in this folder" in refused("evaluate", name, "--data", place / "data")
    said = refused("evaluate", "0.1", "--data", "gone")
    assert "gone: no such file; allowed: a CSV or Parquet file, or a folder with points.csv" in said


@pytest.mark.parametrize("words", ["evaluate -0.1 --data DATA", "pack -.1 -o OUT"])
def test_a_number_below_zero_is_no_option(words: str, refused: Check, place: Path, tmp_path: Path) -> None:
    places = {"DATA": str(place / "data"), "OUT": str(tmp_path / "law.fmu")}
    said = refused(*(places.get(word, word) for word in words.split()))
    assert "mu is -0.1, allowed: a number from 0 to 10" in said


def test_a_number_is_not_refitted(refused: Check, place: Path, tmp_path: Path) -> None:
    """It was, and went on under its name: "0.2 + stribeck" had a constant of 0.09."""
    said = refused("refine", "--data", place / "data", "--model", "0.2", "--add", "viscous", "-o", tmp_path / "m")  # fmt: skip
    assert "0.2: a number is a fixed law; allowed: a model folder or the name of a family" in said


def test_files_that_are_no_fmus(refused: Check, place: Path, tmp_path: Path, tiny: dict[str, Path]) -> None:
    garbage = tmp_path / "garbage.fmu"
    garbage.write_bytes(b"not an archive")
    data = place / "data"
    assert "not an FMU" in refused("evaluate", garbage, "--data", data)
    assert "'v_rel'" in refused("evaluate", tiny["law"], "--data", data)  # a foreign FMU
    assert "garbage.fmu" in refused("compare", "--models", garbage, "0.08", "--data", data)
    assert "suffix" in refused("pack", place / "linear", "-o", tmp_path / "friction.zip")


def test_systems_that_do_not_hold(refused: Check, tmp_path: Path, tiny: dict[str, Path]) -> None:
    system = tmp_path / "system.yaml"
    system.write_text(
        "communication_step: 0.1\nstop_time: 1.0\ncomponents:\n"
        f"  friction: {{fmu: {tiny['law']}}}\n  forming: {{fmu: {tiny['process']}}}\n"
        "connections: ['forming.load -> friction.load']\n"
    )
    said = refused("simulate", system, "-o", tmp_path / "run")
    assert "forming.mu is not connected" in said and "friction.mu -> forming.mu" in said
    swap = ["--swap", f"fricton={tiny['law']}"]
    assert "did you mean 'friction'" in refused("simulate", system, *swap, "-o", tmp_path / "run")
    assert "component=FILE.fmu" in refused("simulate", system, "--swap", "friction", "-o", tmp_path / "r")
    twice = ["--swap", "friction=.1", "--swap", "friction=.2", "-o", tmp_path / "r"]
    assert "component 'friction' is given '.1' and '.2'" in refused("simulate", system, *twice)
    assert "no such file" in refused("simulate", tmp_path / "no.yaml", "-o", tmp_path / "run")
    assert (
        f"{tmp_path}: is a folder; allowed: a system description (.yaml) or an SSP archive (.ssp); did you mean '{system}'?"
        in refused("simulate", tmp_path, "-o", tmp_path / "run")
    )


def test_a_component_that_fails_is_a_failure_not_bad_input(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, tiny: dict[str, Path]
) -> None:
    system = tmp_path / "system.yaml"
    system.write_text(
        "communication_step: 0.1\nstop_time: 1.0\ncomponents:\n"
        f"  friction: {{fmu: {tiny['fragile_law']}}}\n  forming: {{fmu: {tiny['process']}}}\n"
        "connections: ['forming.load -> friction.load', 'friction.mu -> forming.mu']\n"
    )
    assert run(["simulate", str(system), "-o", str(tmp_path / "run")]) == 1
    assert "component 'friction' failed at t = " in capsys.readouterr().err
    assert json.loads((tmp_path / "run" / "manifest.json").read_text())["status"] == "stopped"
    assert run(["report", str(tmp_path / "run")]) == 0  # what it had is kept and shown
    assert "component 'friction' failed" in (tmp_path / "run" / "report.html").read_text().replace(
        "&#x27;", "'"
    )
    results = tmp_path / "run" / "results.nc"
    results.write_bytes(results.read_bytes()[:-50])
    assert run(["report", str(tmp_path / "run")]) == 2
    assert f"{results}: damaged or cut short (" in capsys.readouterr().err


def test_train_honours_uncertain_loads_unless_told_not_to(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frame = points()
    DataSet(frame.assign(u_T=np.where(frame["test_id"] < "t3", 150.0, 1.0))).save(tmp_path / "data")
    DataSet(frame).save(tmp_path / "without")
    said, cards = {}, {}
    for name, data, more in (
        ("honoured", "data", []),
        ("ignored", "data", ["--ignore-load-uncertainty"]),
        ("plain", "without", []),
    ):
        words = ["train", "linear", "--data", tmp_path / data, "-o", tmp_path / name, *more]
        assert run([str(word) for word in words]) == 0
        said[name] = capsys.readouterr().out.replace(str(tmp_path / name), "")
        cards[name] = json.loads((tmp_path / name / "card.json").read_text())
    assert "Uncertain loads honoured: weights by effective variance, worth " in said["honoured"]
    assert said["ignored"] == said["plain"]
    assert cards["ignored"] == cards["plain"] != cards["honoured"]
    assert "Uncertain loads honoured" in (tmp_path / "honoured" / "card.md").read_text()


def test_train_evaluate_predict(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data, model = str(place / "data"), str(tmp_path / "model")
    assert run(["train", "polynomial", "--data", data, "--set", "degree=1", "-o", model]) == 0
    assert "synthetic" in capsys.readouterr().out
    assert run(["evaluate", model, "--data", data, "--json", str(tmp_path / "errors.json")]) == 0
    content = json.loads((tmp_path / "errors.json").read_text())
    assert content["synthetic"] is True
    assert content["roles"].keys() == {"train", "test"}
    card = json.loads((tmp_path / "model" / "card.json").read_text())
    assert "'test'" in str(card) or '"test"' in json.dumps(card)
    for name in ("out.csv", "out.parquet"):
        assert run(["predict", model, "--data", data, "-o", str(tmp_path / name)]) == 0
    table = pd.read_csv(tmp_path / "out.csv")
    assert len(table) == len(pd.read_parquet(tmp_path / "out.parquet")) == 180
    assert (table["mu_model"] - table["mu"]).abs().mean() < 0.01
    capsys.readouterr()
    assert run(["predict", "0.1", "--data", str(tmp_path / "out.csv"), "-o", str(tmp_path / "anew.csv")]) == 0
    said = "out.csv: the predictions there (mu_model) are replaced in"
    assert said in capsys.readouterr().err
    assert set(pd.read_csv(tmp_path / "anew.csv")["mu_model"]) == {0.1}


def test_synthetic_data_that_lack_a_load_stay_synthetic(
    place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = DataSet.load(place / "data")
    DataSet(data.points, data.tests, {"synthetic": True}).save(tmp_path / "less")
    points_file = tmp_path / "less" / "points.csv"
    pd.read_csv(points_file, skiprows=[1]).drop(columns="psi").to_csv(points_file, index=False)
    words = ["diagnose", "--data", str(tmp_path / "less"), "--model", "linear"]
    assert run([*words, "--json", str(tmp_path / "found.json")]) == 0
    assert "synthetic" in capsys.readouterr().out
    assert json.loads((tmp_path / "found.json").read_text())["synthetic"] is True
    # So do data whose test table alone says so.
    (tmp_path / "less" / "dataset.json").unlink()
    table = tmp_path / "less" / "tests.csv"
    pd.read_csv(table).assign(synthetic=True).to_csv(table, index=False)
    assert run(words) == 0 and "synthetic" in capsys.readouterr().out
    DataSet(data.points, data.tests.assign(synthetic=True), {}).save(tmp_path / "more")
    assert DataSet.load(tmp_path / "more").synthetic


def test_interrupts_say_what_was_kept(capsys: pytest.CaptureFixture[str]) -> None:
    from orchestrator.cli.common.console import Interrupted

    with pytest.raises(Interrupted, match="3 tests are kept"), keeping(lambda: "3 tests are kept"):
        raise KeyboardInterrupt


def test_json_holds_no_nan() -> None:
    content = plain(
        {"a": np.float64(np.nan), "b": np.array([1.0, np.inf]), "c": np.int64(3), "d": Path("x/y")}
    )
    assert content == {"a": None, "b": [1.0, None], "c": 3, "d": "x/y"}
    json.dumps(content, allow_nan=False)


def test_every_error_of_the_package_is_an_input_error_or_says_its_type(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], place: Path
) -> None:
    def fails(*_: object, **__: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(DataSet, "load", fails)
    assert run(["evaluate", "0.08", "--data", str(place / "data")]) == 1
    assert capsys.readouterr().err == "tribofmu: error: ZeroDivisionError: division by zero\n"
    monkeypatch.setattr(DataSet, "load", lambda *_, **__: (_ for _ in ()).throw(InputError("x: no")))
    assert run(["evaluate", "0.08", "--data", str(place / "data")]) == 2


def test_a_solver_that_refuses_a_value_is_heard(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert run(["pack", "forming", "--set", "n_points=20", "-o", str(tmp_path / "forming.fmu")]) == 0
    (tmp_path / "fre.yaml").write_text(
        "communication_step: 0.02\nstop_time: 0.04\ncomponents:\n"
        "  forming: {fmu: forming.fmu, start: {half_angle: 89.0, mu: 0.08}}\n"
    )
    assert run(["simulate", str(tmp_path / "fre.yaml"), "-o", str(tmp_path / "run")]) == 1
    said = capsys.readouterr().err.strip()
    assert said.endswith("half_angle = 89.0 degrees; allowed: 10 to 80 degrees")


def test_settings_in_units_that_do_not_fit_are_refused(refused: Check, tmp_path: Path) -> None:
    plan = tmp_path / "plan.csv"
    plan.write_text("sigma_set [MPa],v_set [mm/s],T_tool [s]\n1000,50,293.15\n")
    said = refused("lab", "--plan", plan, "-o", tmp_path / "campaign")
    assert f"{plan}: unknown unit of column 'T_tool' 's'; allowed: K, degC, degF" in said
    press = tmp_path / "press"
    press.mkdir()
    (press / "a.csv").write_text("stroke [mm],force [kN]\n0,0\n1,10\n")
    (press / "levels.csv").write_text(
        "process,T_tool [°C],speed [MPa],lubricant,file\nfre,20,0.005,oil,a.csv\n", encoding="utf-8"
    )
    said = refused("compare", "--models", "0.08", "--press", press)
    assert "unit of column 'speed' 'MPa'; allowed: " in said and "mm/s" in said
    (press / "levels.csv").write_text(
        "process;T_tool;speed;lubricant;file\nfre;20,5;5;oil;a.csv\nfre;20,5;5;oil;a.csv\n", encoding="utf-8"
    )
    said = refused("compare", "--models", "0.08", "--press", press)
    assert "row 1: file 'a.csv' stands above already" in said


def test_numbers_of_set_are_read_as_they_are_written() -> None:
    """YAML takes 1e3 for a text."""
    found = key_values(["speed=1e3", "mu=2E-2", "n=12", "name=16MnCr5", "material=1e3"], ("material",))
    assert found == {"speed": 1000.0, "mu": 0.02, "n": 12, "name": "16MnCr5", "material": "1e3"}
    with pytest.raises(InputError, match="degree is set twice; allowed: once"):
        key_values(["degree=2", "degree=3"])
