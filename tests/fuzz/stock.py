"""Good files for every parameter that takes one, and the folder in which commands are tried on damaged copies of them."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from friction_models import cards
from orchestrator.cli.main import run
from sct_twin.ingest.campaign_files import ingest
from sct_twin.records.channels import CHANNELS
from tests.acceptance.attacks import Attack, Sandbox
from tests.fmus.graphs import graph_bytes, node
from tests.orchestrator.cli.test_command_line import points
from tests.sct_twin.conftest import made_up
from tests.sct_twin.reader_files import write_plain

#: Good files by "command.parameter", then by kind; below the root of the sandbox.
GOOD = {
    **{"pack.spec": "more/spec.yaml", "simulate.system yaml": "a/b/c/system.yaml", "export.system yaml": "a/b/c/system.yaml"},
    **{"lab.plan": "more/plan.csv", "ingest.channels": "more/channels.yaml", "ingest.files": "more/raw/t0.csv"},
    **{"ingest.tests": "more/raw/tests.csv", "compare.press": "more/press", "compare.data folder": "more/press"},
    **{"study forming-error.press": "more/press", "simulate.press": "more/press/fre.csv", "predict-sct.plan": "more/plan.csv"},
    **{"predict-sct.inputs": "more/inputs.csv", "coverage.run": "more/run", "report.folder": "more/run"},
    **{"attribute.system": "a/b/c/system.yaml", "attribute.press": "more/press", "evaluate.model folder": "linear"},
    **{"evaluate.data folder": "data", "twin.campaign": "more/campaign"},
    **{"fmu": "good.fmu", "ssp": "good.ssp", "onnx": "model.onnx", "csv": "points.csv", "parquet": "more/points.parquet"},
    **{"coverage.history": "more/numbered.csv", "coverage.data": "more/numbered.csv", "study learning-curve.data": "more/six.csv"},
    **{"study lag.data": "more/six.csv", "study forming-error.data": "more/six.csv", "study extrapolation.data": "more/six.csv"},
    **{"cards.name": "more/cards/bad.yaml", "cards.folder": "more/cards", "train.card": "more/cards/bad.yaml"},
    **{"diagnose.after": "more/before.json", "pack.diagnosis": "more/before.json", "points.columns": "more/points.yaml", "tests": "data/tests.csv", "names": "more/names.yaml", "compare.system": "a/b/c/system.yaml"},
}  # fmt: skip
FOREIGN = {"notes.txt": b"years of work\n", "sub/data.csv": b"a,b\n1,2\n", "results.nc": b"not ours\n"}


def good(attack: Attack) -> str:
    """Return the good file for a parameter, relative to the root."""
    name = f"{attack.command}.{attack.parameter}"
    for key in (f"{name} {attack.kind}", name, attack.parameter, attack.kind):
        if key in GOOD:
            return GOOD[key]
    raise KeyError(f"no good file for {name}, {attack.kind}")


def make_stock(root: Path) -> Path:
    """Write all good files below `root`; return it."""
    Sandbox(root)
    more = root / "more"
    more.mkdir()
    write_yaml(
        more / "names.yaml", {"good.fmu": {n: n for n in ("v_rel", "T", "sigma_n", "sd", "psi", "mu")}}
    )
    columns = {"T": {"column": 1, "unit": "degC", "range": [20.0, 400.0]}}
    columns |= {"v_rel": {"column": 0, "unit": "mm/s"}, "sigma_n": {"column": 2, "unit": "MPa"}}
    columns |= {"sd": {"column": 3, "unit": "mm"}, "psi": {"column": 4, "unit": "1"}}
    write_yaml(
        more / "spec.yaml", {"name": "a law", "inputs": columns, "output": {"multiply": 1.0, "add": 0.0}}
    )
    frame = pd.read_csv(root / "points.csv")
    write_yaml(more / "points.yaml", {"columns": {name: str(name) for name in frame}})
    frame.to_parquet(more / "points.parquet")
    frame.assign(test_id=frame["test_id"].str[1:]).to_csv(more / "numbered.csv", index=False)
    points(6, 8).to_csv(more / "six.csv", index=False)
    law = {"w": np.array([[0.0], [-1e-4], [1e-5], [0.0], [0.0]]), "b": np.array([0.15])}
    (more / "user.onnx").write_bytes(graph_bytes([node("Gemm", "loads w b", "mu")], law))
    tests = pd.DataFrame(
        {"test_id": ["t0", "t1", "t2"], "role": ["train", "train", "test"], "v_set": [50.0, 60.0, 70.0]}
    )
    tests.to_csv(root / "data" / "tests.csv", index=False)
    budget = {"floor": 0.005, "explained": 0.0, "missing": 0.0}
    answer = {
        "verdict": "nothing_missing",
        "effects": [],
        "confusion_set": [],
        "confidence": 0.5,
        "error_budget": budget,
    }
    (more / "before.json").write_text(json.dumps(answer), encoding="utf-8")
    _card(more / "cards")
    _measured(more)
    _press(more / "press")
    assert run(["simulate", str(root / "a/b/c/system.yaml"), "-o", str(more / "run")]) == 0
    return root


def _card(folder: Path) -> None:
    """A card as one that comes with the package, under the name that a damaged copy of it has, too."""
    folder.mkdir()
    text = (Path(cards.__file__).parent / "data" / "rock-byerlee.yaml").read_text(encoding="utf-8")
    (folder / "bad.yaml").write_text(text.replace("name: rock-byerlee", "name: bad"), encoding="utf-8")


def _measured(more: Path) -> None:
    """A record, what it is called in its file, the campaign that it makes, a plan and a course for the twin."""
    raw = more / "raw"
    raw.mkdir()
    record = made_up(noise=1.0, sliding=2.0).to_frame()
    units = {name: CHANNELS[name].unit for name in record.columns}
    write_plain(raw / "t0.csv", record, units)
    row = {"test_id": "t0", "v_set": 50.0, "T_tool": 20.0, "bore": 15.51, "lubricant": "made up"}
    pd.DataFrame([row]).to_csv(raw / "tests.csv", index=False)
    columns = {name: {"quantity": name, "unit": unit} for name, unit in units.items()}
    channels = {"channels": columns, "moving_mass": 25.0, "metadata": {"lubricant": "made up"}}
    write_yaml(more / "channels.yaml", channels)
    ingest(raw, channels, more / "campaign")
    plan = {
        "test_id": "p0",
        "sigma_set": 500.0,
        "psi_set": 1.069,
        "v_set": 50.0,
        "T_tool": 20.0,
        "sd_set": 2.0,
    }
    pd.DataFrame([plan | {"role": "train", "bore": 15.51, "F_set": 94468.0}]).to_csv(
        more / "plan.csv", index=False
    )
    t = np.linspace(0.0, 0.5, 20)
    course = {
        "t [s]": t,
        "F_n [N]": 90e3 + 0.0 * t,
        "v_slide [mm/s]": np.where(t < 0.3, 0.0, 20.0),
        "T_tool": 20.0 + 0.0 * t,
    }
    pd.DataFrame(course).to_csv(more / "inputs.csv", index=False)


def _press(folder: Path) -> None:
    folder.mkdir()
    level = {"process": "fre", "T_tool": 20.0, "speed": 5.0, "lubricant": "made up", "file": "fre.csv"}
    pd.DataFrame([level]).to_csv(folder / "levels.csv", index=False)
    stroke = np.linspace(0.0, 0.6, 13)
    pd.DataFrame({"stroke [mm]": stroke, "force [kN]": 200.0 * stroke, "repeat": 0}).to_csv(
        folder / "fre.csv", index=False
    )
    settings = {"process": {"diameter": 20, "billet_length": 30}, "T_billet_degC": 20}
    (folder / "press.json").write_text(json.dumps(settings), encoding="utf-8")


def write_yaml(path: Path, content: object) -> None:
    path.write_text(yaml.safe_dump(content), encoding="utf-8")


class Box(Sandbox):
    """A copy of the stock in which one command at a time runs; everything in it is watched.

    Parameters
    ----------
    stock, root : Path
        From `make_stock`, and where the copy goes.
    """

    def __init__(self, stock: Path, root: Path) -> None:
        self.stock, self.root = stock, root
        self.place, self.secret, self.fmu = root / "a/b/c", root / "secret.txt", root / "good.fmu"
        self.known = {
            "data": root / "data",
            "points": root / "points.csv",
            "onnx": root / "model.onnx",
            "fmu": self.fmu,
            "system": self.place / "system.yaml",
            "with_bad": self.place / "with_bad.yaml",
            "out": self.place / "out",
        }
        self.renew()

    def renew(self) -> None:
        """Make everything as it was."""
        shutil.rmtree(self.root, ignore_errors=True)
        shutil.copytree(self.stock, self.root)
        for place in ("neighbour", "tmp"):
            (self.root / place).mkdir(exist_ok=True)
        put_foreign(self.root / "neighbour")
        self.pristine = self.look()

    def words(self, attack: Attack, bad: str, out: str) -> list[str]:
        """Return the command line of an attack."""
        values = self.known | {"bad": bad, "out": out}
        if attack.command == "ingest":
            values["points"] = self.root / "more/raw/t0.csv"
        if attack.command == "coverage":  # a history of contact, too: numbers only
            values["points"] = self.root / "more/numbered.csv"
        if attack.parameter == "spec":
            values["onnx"] = self.root / "more/user.onnx"
        if attack.command == "attribute":
            values["data"] = self.root / "more/press"
        words = [word.format_map(values) for word in attack.arguments.split()]
        if attack.command == "study forming-error":  # it wants both
            other = ("--data", "more/six.csv") if attack.parameter == "press" else ("--press", "more/press")
            words += [other[0], str(self.root / other[1])]
        return [*attack.command.split(), *words]

    def look(self) -> dict[str, str]:
        """Return what stands below the root: a digest of each file, the target of each link."""
        found = {}
        for folder, folders, files in os.walk(self.root):
            relative = os.path.relpath(folder, self.root)
            if relative == "tmp":
                folders.clear()
                continue
            for name in (*folders, *files):
                path = os.path.join(folder, name)
                key = os.path.normpath(os.path.join(relative, name))
                if os.path.islink(path):
                    found[key] = f"link to {os.readlink(path)}"
                elif os.path.isfile(path):
                    state = os.stat(path)
                    with open(path, "rb") as stream:
                        found[key] = f"{hashlib.file_digest(stream, 'sha1').hexdigest()} {state.st_mtime_ns}"
                else:
                    found[key] = "folder"
        return found


def put_foreign(folder: Path) -> None:
    """Fill a folder with files of somebody else."""
    for name, content in FOREIGN.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
