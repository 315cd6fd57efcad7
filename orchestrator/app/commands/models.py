"""The command lines about models: what they are missing, what is added, how they compare."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from friction_models.common.wording import counted, listed

from ..project import name_of
from .command import Command, short

#: Families that a model can start from without being trained before.
FAMILIES = ("linear", "polynomial", "power_law", "constant")


def diagnosis_files(data: str, model: str) -> tuple[str, str, str]:
    """Return where the answer about a model is kept: JSON, page and plan of the next tests."""
    stem = f"reports/diagnosis-{short(data)}-{short(model)}"
    return f"{stem}.json", f"{stem}.html", f"{stem}-next-tests.csv"


def diagnose(data: str, model: str) -> Command:
    """Ask what a model is missing."""
    json, page, plan = diagnosis_files(data, model)
    arguments = (
        *("diagnose", "--data", data, "--model", model),
        *("--json", json, "--report", page, "--plan", plan),
    )
    return Command(f"What is {short(model)} missing?", arguments)


def model_name(name: str, data: str, learnt: Mapping[str, str]) -> str:
    """Return how a model of some measurements is called: another name where that of others has this one, so that none is replaced.

    `learnt` says of the models that there are what they were fitted to.

    Examples
    --------
    >>> model_name("linear", "data/sct", {"models/linear": "data/oil"}), model_name("linear", "data/sct", {})
    ('linear-sct', 'linear')
    """
    taken = learnt.get(f"models/{name}", data) != data
    return name_of(f"{name}-{short(data)}") if taken else name


def refine(data: str, model: str, effects: Sequence[str], learnt: Mapping[str, str] | None = None) -> Command:
    """Add effects to a model.

    `learnt` as for `model_name`.

    Examples
    --------
    >>> refine("data/sct", "linear", ["factor:batch"]).arguments[-3]
    'models/linear-factor-batch'
    >>> refine("data/sct", "linear", ["factor:batch"], {"models/linear-factor-batch": "data/oil"}).arguments[-3]
    'models/linear-factor-batch-sct'
    """
    added = "-".join(name_of(effect) for effect in effects)
    out = f"models/{model_name(name_of(f'{short(model)}-{added}'), data, learnt or {})}"
    page = f"reports/refined-{short(data)}-{short(out)}.html"
    arguments = ("refine", "--data", data, "--model", model, "--add", *effects, "-o", out, "--report", page)
    return Command(
        f"Add {listed(effects)} to {short(model)}",
        arguments,
        {"round": {"model": out, "added": list(effects), "report": page}},
    )


def train(data: str, family: str, name: str = "") -> Command:
    """Train a model of a family; `name` where it is not to be called as its family."""
    out = f"models/{name or family}"
    return Command(f"Train a {family} model", ("train", family, "--data", data, "-o", out))


def comparison_points(data: str) -> str:
    """Return where the points of a comparison are kept, with mu of every model."""
    return f"reports/comparison-{short(data)}.parquet"


def compare(data: str, models: Sequence[str]) -> Command:
    """Compare models on a data set."""
    stem = f"reports/comparison-{short(data)}"
    arguments = (
        *("compare", "--models", *models, "--data", data),
        *("--json", f"{stem}.json", "--report", f"{stem}.html", "--points", comparison_points(data)),
    )
    return Command(f"Compare {counted(len(models), 'model')}", arguments)
