"""Options that several commands share, and reading what they name."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from friction_models.loads import DataSet

    from ..foreign_friction import GivenNames
    from ..system import System

Data = Annotated[
    Path, typer.Option("--data", help="Data set: a folder with points.csv, or a CSV or Parquet file.")
]
Tests = Annotated[
    Path | None, typer.Option("--tests", help="Test table (one row a test), where --data is a single file.")
]
OutFolder = Annotated[Path, typer.Option("-o", "--out", help="Folder to write.")]
OutFile = Annotated[Path, typer.Option("-o", "--out", help="File to write.")]
Json = Annotated[Path | None, typer.Option("--json", help="Also write the result to this JSON file.")]
Names = Annotated[
    Path | None,
    typer.Option(
        "--names", help="YAML file: which variables of FMUs that others made take the loads and give mu."
    ),
]
Swap = Annotated[
    list[str] | None, typer.Option("--swap", help="Run another FMU in a component: friction=FILE.fmu.")
]
Jobs = Annotated[
    int | None, typer.Option("--jobs", "-j", min=1, help="Processes to use (default: all cores).")
]


def read_data(data: Path, tests: Path | None = None, need_mu: bool = True) -> DataSet:
    """Read the data set behind `--data` and `--tests`."""
    from friction_models.loads import DataSet

    return DataSet.load(data, tests, need_mu=need_mu)


def swapped(system: System, swap: Iterable[str] | None) -> System:
    """Return the system with other FMUs in the components that `--swap` names.

    Raises
    ------
    InputError
        A text that is not ``component=FILE.fmu``, no such component, or no such file.
    """
    from friction_models.loads import InputError

    for item in swap or []:
        component, equals, file = item.partition("=")
        if not equals or not file:
            raise InputError(f"--swap {item!r}: not of the form component=FILE.fmu")
        system = system.swap(component, file)
    return system


def named_model(name: str, parameters: Iterable[str] = ()) -> Any:
    """Return the unfitted model of a family; `parameters` are ``key=value``."""
    from friction_models.registry import make_model

    return make_model(name, **key_values(parameters))


def given_names(models: Sequence[str], names: Path | None) -> GivenNames:
    """Return what the file behind `--names` says of the models."""
    from ..foreign_friction import GivenNames

    return GivenNames.read(models, names)


def any_model(name: str, names: GivenNames | None = None) -> Any:
    """Return what `--model` names: a model folder, a friction FMU, an ONNX file, a number (constant mu) or a family.

    Parameters
    ----------
    name : str
    names : GivenNames, optional
        What `given_names` returned.

    Raises
    ------
    InputError
        None of them; the message holds the nearest family.
    """
    path = Path(name)
    if path.suffix == ".fmu":
        from ..foreign_friction import ForeignFmu, GivenNames

        model = (names or GivenNames()).open(name)
        if isinstance(model, ForeignFmu) and model.remark():
            typer.echo(f"note: {model.remark()}", err=True)
        return model
    if path.suffix == ".onnx":
        from friction_models.onnx_model import OnnxModel

        return OnnxModel(path)
    if path.is_dir():
        from friction_models import load_model

        return load_model(path)
    number = as_number(name)
    if number is not None:
        from friction_models import ConstantFriction

        return ConstantFriction(number)
    if "/" in name or "\\" in name or path.suffix:
        from friction_models.loads import InputError

        raise InputError(
            f"{name}: no such model; allowed: a model folder, an .fmu or .onnx file, a number or a model family{_near(path)}"
        )
    return named_model(name)


def _near(path: Path) -> str:
    """Return a question for the nearest name beside a path that is not there."""
    from friction_models.loads import nearest

    beside = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
    hint = nearest(path.name, beside)
    return f"; did you mean {str(path.parent / hint)!r}?" if hint else ""


def fitted_model(name: str, names: GivenNames | None = None) -> Any:
    """Return the model behind a name as `any_model` does; it must be able to predict."""
    model = any_model(name, names)
    if not getattr(model, "is_fitted", True):
        from friction_models.loads import InputError

        raise InputError(
            f"{name}: the name of a family, not a trained model; allowed: a model folder, an .fmu or .onnx file, or a number"
        )
    return model


def as_number(text: str) -> float | None:
    """Return the number that a text is, or None."""
    try:
        return float(text)
    except ValueError:
        return None


def key_values(pairs: Iterable[str]) -> dict[str, Any]:
    """Read ``key=value`` texts; values as YAML reads them.

    Raises
    ------
    InputError
        A text without an equals sign, or a value that is not YAML.
    """
    import yaml

    from friction_models.loads import InputError

    result: dict[str, Any] = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key:
            raise InputError(f"{pair!r}: not of the form key=value")
        try:
            result[key] = yaml.safe_load(value)
        except yaml.YAMLError:
            raise InputError(f"{pair!r}: the value cannot be read") from None
    return result
