"""The command lines of the pages Forming and Reports, and where their results are kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

from friction_models.common.wording import counted

from ..project import name_of
from .command import Command, short


@dataclass(frozen=True)
class Forming:
    """What is to be formed.

    Attributes
    ----------
    process : str
    models : sequence of str
        Model folders, FMUs, ONNX files and numbers.
    values : mapping of str to str
        Parameters of the process that differ from its defaults.
    speeds, temperatures : sequence of float
        Punch speeds [mm/s] and tool temperatures [degC]; each pair of them is a level.
    stroke : float or None
        [mm]
    press : str
        Curve of one press level; empty for none.
    local_errors : bool
    name : str
        Of the results.

    Examples
    --------
    >>> plan = Forming("fre", ["models/linear", "0.08"], {"half_angle": "30"}, [5.0, 50.0], [20.0], 10.0)
    >>> form(plan).line[:99]
    'tribofmu compare --process fre --set half_angle=30 --level speed=5,T_tool=20 --level speed=50,T_too'
    """

    process: str
    models: Sequence[str]
    values: Mapping[str, str] = field(default_factory=dict)
    speeds: Sequence[float] = ()
    temperatures: Sequence[float] = ()
    stroke: float | None = None
    press: str = ""
    local_errors: bool = False
    name: str = ""

    @property
    def called(self) -> str:
        """Name of the results, as a file may be called."""
        return name_of(self.name) if self.name.strip() else self.process


def results(name: str) -> tuple[str, str, str]:
    """Return where the results of that name are kept: folder of the runs, JSON and page."""
    return f"runs/{name}", f"reports/forming-{name}.json", f"reports/forming-{name}.html"


def form(plan: Forming) -> Command:
    """Form a process with several friction models."""
    runs, json, page = results(plan.called)
    arguments = ["compare", "--process", plan.process]
    for name, value in plan.values.items():
        arguments += ["--set", f"{name}={value}"]
    for speed, temperature in product(plan.speeds, plan.temperatures):
        arguments += ["--level", f"speed={speed:g},T_tool={temperature:g}"]
    if plan.stroke is not None:
        arguments += ["--stroke", f"{plan.stroke:g}"]
    arguments += ["--models", *plan.models]
    if plan.press:
        arguments += ["--press", plan.press]
    if plan.local_errors:
        arguments += ["--local-errors"]
    arguments += ["--runs", runs, "--json", json, "--report", page]
    return Command(
        f"Form {plan.called} with {counted(len(plan.models), 'friction model')}",
        tuple(arguments),
    )


def form_press(press: str, models: Sequence[str]) -> Command:
    """Form every level of a folder of press curves.

    Examples
    --------
    >>> form_press("press/rods", ["0.08"]).arguments[:5]
    ('compare', '--press', 'press/rods', '--models', '0.08')
    """
    runs, json, page = results(f"press-{short(press)}")
    arguments = (
        *("compare", "--press", press, "--models", *models),
        *("--runs", runs, "--json", json, "--report", page),
    )
    return Command(f"Form every level of {short(press)}", arguments)


def coverage_files(data: str, name: str) -> tuple[str, str, str]:
    """Return where the coverage of a run by a data set is kept: JSON, page and plan of further tests."""
    stem = f"reports/coverage-{short(data)}-{name}"
    return f"{stem}.json", f"{stem}.html", f"{stem}-tests.csv"


def coverage(data: str, run: str, name: str) -> Command:
    """Say where a run leaves the tested loads."""
    json, page, plan = coverage_files(data, name)
    arguments = (
        *("coverage", "--data", data, "--run", run),
        *("--json", json, "--report", page, "--plan", plan),
    )
    return Command(f"Which loads of {name} were tested", arguments)


#: Where the story of a project is kept.
STORY = "reports/story.html"


def story() -> Command:
    """Tell the story of the project on one page.

    Examples
    --------
    >>> story().line
    'tribofmu story . -o reports/story.html'
    """
    return Command("Tell the story of the project", ("story", ".", "-o", STORY))
