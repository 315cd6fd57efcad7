"""Through which parameter of which command a hostile file comes in, and the folder in which that is tried."""

from __future__ import annotations

import gc
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from fmus import pack
from friction_models import LinearFriction
from friction_models.loads import DataSet
from orchestrator.cli.main import run
from tests.fmus.graphs import BOX, graph_bytes, node
from tests.orchestrator.cli.test_command_line import points

from .hostile import SECRET


@dataclass(frozen=True)
class Attack:
    """A command and the parameter through which it is given a file.

    Attributes
    ----------
    command, parameter : str
    kind : str
        What kind of file is expected: ``fmu``, ``ssp``, ``onnx``, ``yaml``, ``csv``, ``json`` or ``folder``.
    arguments : tuple of str
        ``{bad}`` is the hostile file; other names in braces are good files of the sandbox.
    files : tuple of str
        For folders: the files in it that are hostile.
    """

    command: str
    parameter: str
    kind: str
    arguments: str
    files: tuple[str, ...] = ()


ATTACKS = [
    Attack("check", "fmu", "fmu", "{bad}"),
    Attack("evaluate", "model", "fmu", "{bad} --data {data}"),
    Attack("predict", "model", "fmu", "{bad} --data {data} -o {out}.csv"),
    Attack("compare", "models", "fmu", "--models 0.1 {bad} --data {data}"),
    Attack("diagnose", "model", "fmu", "--data {data} --model {bad}"),
    Attack("refine", "model", "fmu", "--data {data} --model {bad} --add stribeck -o {out}"),
    Attack("simulate", "system", "fmu", "{with_bad} -o {out}"),
    Attack("simulate", "swap", "fmu", "{system} --swap friction={bad} -o {out}"),
    Attack("export", "system", "fmu", "{with_bad} -o {out}.ssp"),
    Attack("export", "swap", "fmu", "{system} --swap friction={bad} -o {out}.ssp"),
    Attack("pack", "model", "fmu", "{bad} -o {out}.fmu"),
    Attack("simulate", "system", "ssp", "{bad} -o {out}"),
    Attack("export", "system", "ssp", "{bad} -o {out}.ssp"),
    Attack("pack", "model", "onnx", "{bad} -o {out}.fmu"),
    Attack("pack", "model", "onnx", "{bad} --target python -o {out}.fmu"),
    Attack("pack", "spec", "yaml", "{onnx} --spec {bad} -o {out}.fmu"),
    Attack("pack", "diagnosis", "json", "{onnx} --diagnosis {bad} -o {out}.fmu"),
    Attack("simulate", "system", "yaml", "{bad} -o {out}"),
    Attack("export", "system", "yaml", "{bad} -o {out}.ssp"),
    Attack("lab", "plan", "csv", "--plan {bad} -o {out}"),
    Attack("ingest", "channels", "yaml", "{points} --map {bad} -o {out}"),
    Attack("ingest", "files", "csv", "{bad} -o {out}"),
    Attack("ingest", "tests", "csv", "{points} --tests {bad} -o {out}"),
    Attack("cards", "name", "yaml", "{bad}"),
    Attack("cards", "folder", "folder", "--folder {bad}", ("own.yaml",)),
    Attack("train", "card", "yaml", "constant --from card:{bad} --data {data} -o {out}"),
    Attack("points", "columns", "yaml", "{points} --map {bad} -o {out}"),
    Attack("points", "files", "csv", "{bad} -o {out}"),
    Attack("tests", "data", "csv", "{bad} --set *:mark=x"),
    Attack("train", "data", "csv", "linear --data {bad} -o {out}"),
    Attack("train", "data", "parquet", "linear --data {bad} -o {out}"),
    Attack("train", "tests", "csv", "linear --data {points} --tests {bad} -o {out}"),
    Attack("evaluate", "data", "csv", "0.1 --data {bad}"),
    Attack("evaluate", "tests", "csv", "0.1 --data {points} --tests {bad}"),
    Attack("predict", "data", "csv", "0.1 --data {bad} -o {out}.csv"),
    Attack("predict", "tests", "csv", "0.1 --data {points} --tests {bad} -o {out}.csv"),
    Attack("compare", "data", "csv", "--models 0.1 --data {bad}"),
    Attack("compare", "tests", "csv", "--models 0.1 --data {points} --tests {bad}"),
    Attack("compare", "names", "yaml", "--models {fmu} --data {data} --names {bad}"),
    Attack("compare", "system", "yaml", "--models 0.1 --system {bad}"),
    Attack("simulate", "names", "yaml", "{system} --swap friction={fmu} --names {bad} -o {out}"),
    Attack("export", "names", "yaml", "{system} --swap friction={fmu} --names {bad} -o {out}.ssp"),
    Attack("evaluate", "names", "yaml", "{fmu} --data {data} --names {bad}"),
    Attack("predict", "names", "yaml", "{fmu} --data {data} --names {bad} -o {out}.csv"),
    Attack("predict-sct", "names", "yaml", "{fmu} --data {data} --names {bad} -o {out}"),
    Attack("diagnose", "names", "yaml", "--model {fmu} --data {data} --names {bad}"),
    Attack("compare", "press", "folder", "--models 0.1 --press {bad}", ("levels.csv", "press.json")),
    Attack("diagnose", "data", "csv", "--data {bad} --model linear"),
    Attack("diagnose", "tests", "csv", "--data {points} --tests {bad} --model linear"),
    Attack("diagnose", "after", "json", "--data {data} --model linear --after {bad}"),
    Attack("refine", "data", "csv", "--data {bad} --model linear --add stribeck -o {out}"),
    Attack("refine", "tests", "csv", "--data {points} --tests {bad} --model linear --add stribeck -o {out}"),
    Attack("simulate", "press", "csv", "{system} --press {bad} -o {out}"),
    Attack("predict-sct", "friction", "fmu", "{bad} --data {data} -o {out}"),
    Attack("predict-sct", "data", "csv", "0.1 --data {bad} -o {out}"),
    Attack("predict-sct", "tests", "csv", "0.1 --data {points} --tests {bad} -o {out}"),
    Attack("predict-sct", "plan", "csv", "0.1 --plan {bad} -o {out}"),
    Attack("predict-sct", "inputs", "csv", "0.1 --inputs {bad} -o {out}"),
    Attack("coverage", "data", "csv", "--data {bad} --history {points}"),
    Attack("coverage", "tests", "csv", "--data {points} --tests {bad} --history {points}"),
    Attack("coverage", "history", "csv", "--data {points} --history {bad}"),
    Attack("coverage", "run", "folder", "--data {data} --run {bad}", ("manifest.json", "results.nc")),
    Attack("attribute", "system", "yaml", "--press {data} --system {bad}"),
    Attack("attribute", "press", "folder", "--press {bad} --system {system}", ("levels.csv", "press.json")),
    Attack("evaluate", "model", "folder", "{bad} --data {data}", ("card.json", "parameters.npz")),
    Attack("evaluate", "data", "folder", "0.1 --data {bad}", ("points.csv", "tests.csv", "dataset.json")),
    Attack("compare", "data", "folder", "--models 0.1 --data {bad}", ("levels.csv", "press.json")),
    Attack(
        "report", "folder", "folder", "{bad} -o {out}.html", ("manifest.json", "results.nc", "system.yaml")
    ),
    Attack("study learning-curve", "data", "csv", "--data {bad} --quick --dry-run -o {out}"),
    Attack("study lag", "data", "csv", "--data {bad} --quick --dry-run -o {out}"),
    Attack("study extrapolation", "data", "csv", "--data {bad} --quick --dry-run -o {out}"),
    Attack("study forming-error", "data", "csv", "--data {bad} --quick --dry-run -o {out}"),
    Attack(
        "study forming-error",
        "press",
        "folder",
        "--press {bad} --quick --dry-run -o {out}",
        ("levels.csv", "press.json"),
    ),
    Attack("twin", "campaign", "folder", "{bad} -o {out}", ("campaign.json", "tests.csv", "raw/t0.nc")),
]


class Sandbox:
    """A folder in a folder in a folder: commands run inside, everything around is watched."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.place = root / "a" / "b" / "c"
        self.place.mkdir(parents=True)
        self.secret = root / "secret.txt"
        self.secret.write_text(SECRET)
        content = graph_bytes(
            [node("Gemm", "loads w b", "mu")],
            {"w": np.array([[0.0], [-1e-4], [1e-5], [0.0], [0.0]]), "b": np.array([0.15])},
            metadata={"domain": BOX},
        )
        (root / "model.onnx").write_bytes(content)
        self.fmu = pack(root / "model.onnx", root / "good.fmu")
        frame = points(3, 10)
        DataSet(frame).save(root / "data")
        frame.to_csv(root / "points.csv", index=False)
        LinearFriction().fit_frame(points()).save(root / "linear")
        start = {"v_rel": 1.0, "T": 20.0, "sigma_n": 100.0, "sd": 0.0, "psi": 1.0}
        for name, fmu in (("system", "../../../good.fmu"), ("with_bad", "bad.fmu")):
            content_of = {"communication_step": 0.1, "stop_time": 0.2}
            part = {"components": {"friction": {"fmu": fmu, "start": start}}}
            (self.place / f"{name}.yaml").write_text(yaml.safe_dump(content_of | part))
        assert run(["export", str(self.place / "system.yaml"), "-o", str(root / "good.ssp")]) == 0
        self.known = {
            "data": root / "data",
            "points": root / "points.csv",
            "onnx": root / "model.onnx",
            "fmu": self.fmu,
            "system": self.place / "system.yaml",
            "with_bad": self.place / "with_bad.yaml",
            "out": self.place / "out",
        }

    def put(self, attack: Attack, content: bytes, file: str = "") -> Path:
        """Write the hostile file (or the folder with one); return it."""
        bad = self.place / ("bad" if attack.kind == "folder" else f"bad.{attack.kind}")
        if attack.kind != "folder":
            bad.write_bytes(content)
            return bad
        shutil.rmtree(bad, ignore_errors=True)
        good = self.root / ("linear" if "card.json" in attack.files else "data")
        shutil.copytree(good, bad)
        for name in attack.files:
            if name == file or not (good / name).is_file():
                (bad / name).parent.mkdir(exist_ok=True)
                (bad / name).write_bytes(content)
        return bad

    def arguments(self, attack: Attack, bad: Path) -> list[str]:
        values = self.known | {"bad": bad}
        return [*attack.command.split(), *(word.format_map(values) for word in attack.arguments.split())]

    def seen(self) -> dict[Path, int]:
        if any((self.root / "tmp").iterdir()):
            gc.collect()  # folders of unpacked FMUs go when their objects do
        return {p: p.stat().st_mtime_ns if p.is_file() else 0 for p in self.root.rglob("*")}
