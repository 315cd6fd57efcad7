"""The command lines of the pages Forming and Reports, and where their results are kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

from friction_models.common.wording import counted

from ..project import name_of
from .command import Command, short


def results(name: str) -> tuple[str, str, str]:
    """Return where the results of that name are kept: folder of the runs, JSON and page."""
    return f"runs/{name}", f"reports/forming-{name}.json", f"reports/forming-{name}.html"


def form(
    process: str,
    models: Sequence[str],
    values: Mapping[str, str],
    speeds: Sequence[float],
    temperatures: Sequence[float],
    stroke: float | None = None,
    press: str = "",
    local_errors: bool = False,
    name: str = "",
) -> Command:
    """Form a process with several friction models: model folders, FMUs, ONNX files and numbers.

    `values` are the parameters of the process that differ from its defaults. Each pair of a punch speed [mm/s] and a tool
    temperature [degC] is a level; `press` is the curve of one press level. The results are called `name`, or as the process.

    Examples
    --------
    >>> form("fre", ["models/linear", "0.08"], {"half_angle": "30"}, [5.0, 50.0], [20.0], 10.0).line[:99]
    'tribofmu compare --process fre --set half_angle=30 --level speed=5,T_tool=20 --level speed=50,T_too'
    """
    called = name_of(name) if name.strip() else process
    runs, json, page = results(called)
    arguments = ["compare", "--process", process]
    for parameter, value in values.items():
        arguments += ["--set", f"{parameter}={value}"]
    for speed, temperature in product(speeds, temperatures):
        arguments += ["--level", f"speed={speed:g},T_tool={temperature:g}"]
    if stroke is not None:
        arguments += ["--stroke", f"{stroke:g}"]
    arguments += ["--models", *models]
    if press:
        arguments += ["--press", press]
    if local_errors:
        arguments += ["--local-errors"]
    arguments += ["--runs", runs, "--json", json, "--report", page]
    return Command(f"Form {called} with {counted(len(models), 'friction model')}", tuple(arguments))


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
