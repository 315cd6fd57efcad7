"""The command lines behind the buttons. Each can be pasted into a shell in the project folder, and gives the same files."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any

from .project import name_of

#: Families that a model can start from without being trained before.
FAMILIES = ("linear", "polynomial", "power_law", "constant")


@dataclass(frozen=True)
class Command:
    """A command line of `tribofmu`.

    Attributes
    ----------
    title : str
        What it does, for people.
    arguments : tuple of str
        Behind ``tribofmu``; paths are relative to the project.
    more : dict
        What the history keeps with its end.
    """

    title: str
    arguments: tuple[str, ...]
    more: dict[str, Any] = field(default_factory=dict)

    @property
    def line(self) -> str:
        """The line as one types it in the project folder."""
        return shlex.join(["tribofmu", *self.arguments])


def effect_names(found: object) -> list[str]:
    """Return the names of effects in a list from a file: texts that the command line takes for names.

    Examples
    --------
    >>> effect_names(["stribeck", "factor:batch", "--force", 3, "a\\nb", ""])
    ['stribeck', 'factor:batch']
    """
    names = found if isinstance(found, list) else []
    return [
        n for n in names if isinstance(n, str) and n.isprintable() and n[:1] not in {"", "-"} and len(n) < 200
    ]


def short(name: str) -> str:
    """Return the name of a data set or model without its folder and suffix.

    Examples
    --------
    >>> short("data/sct"), short("data/lab.csv"), short("linear"), short("0.08"), short("data")
    ('sct', 'lab', 'linear', '0.08', 'data')
    """
    path = PurePosixPath(name)
    return path.stem if path.suffix in {".csv", ".parquet", ".fmu", ".onnx"} else path.name


def diagnosis_files(data: str, model: str) -> tuple[str, str, str]:
    """Return where the answer about a model is kept: JSON, page and plan of the next tests."""
    stem = f"reports/diagnosis-{short(data)}-{short(model)}"
    return f"{stem}.json", f"{stem}.html", f"{stem}-next-tests.csv"


def diagnose(data: str, model: str) -> Command:
    """Ask what a model is missing."""
    json, page, plan = diagnosis_files(data, model)
    arguments = (
        "diagnose",
        "--data",
        data,
        "--model",
        model,
        "--json",
        json,
        "--report",
        page,
        "--plan",
        plan,
    )
    return Command(f"What is {short(model)} missing?", arguments)


def refine(data: str, model: str, effects: Sequence[str]) -> Command:
    """Add effects to a model.

    Examples
    --------
    >>> refine("data/sct", "linear", ["factor:batch"]).arguments[-3]
    'models/linear-factor-batch'
    """
    added = "-".join(name_of(effect) for effect in effects)
    out = f"models/{name_of(f'{short(model)}-{added}')}"
    page = f"reports/refined-{short(data)}-{short(out)}.html"
    arguments = ("refine", "--data", data, "--model", model, "--add", *effects, "-o", out, "--report", page)
    return Command(
        f"Add {' and '.join(effects)} to {short(model)}",
        arguments,
        {"round": {"model": out, "added": list(effects), "report": page}},
    )


def train(data: str, family: str) -> Command:
    """Train a model of a family."""
    return Command(f"Train a {family} model", ("train", family, "--data", data, "-o", f"models/{family}"))


def fmu_file(model: str, fmi: str = "2.0", nodes: int = 1) -> str:
    """Return where the FMU of a model is kept.

    Examples
    --------
    >>> fmu_file("models/linear"), fmu_file("models/linear", "3.0", 80)
    ('fmus/linear.fmu', 'fmus/linear-fmi3-80.fmu')
    """
    more = ("" if fmi == "2.0" else f"-fmi{fmi[0]}") + ("" if nodes == 1 else f"-{nodes}")
    return f"fmus/{short(model)}{more}.fmu"


def pack(model: str, fmi: str = "2.0", nodes: int = 1) -> Command:
    """Pack a model as an FMU."""
    options = (() if fmi == "2.0" else ("--fmi", fmi)) + (() if nodes == 1 else ("--nodes", str(nodes)))
    return Command(
        f"Pack {short(model)} as an FMU", ("pack", model, *options, "-o", fmu_file(model, fmi, nodes))
    )


def check(fmu: str) -> Command:
    """Check an FMU."""
    return Command(f"Check {short(fmu)}", ("check", fmu))


def compare(data: str, models: Sequence[str]) -> Command:
    """Compare models on a data set."""
    stem = f"reports/comparison-{short(data)}"
    arguments = (
        "compare",
        "--models",
        *models,
        "--data",
        data,
        "--json",
        f"{stem}.json",
        "--report",
        f"{stem}.html",
    )
    return Command(f"Compare {len(models)} models", arguments)
