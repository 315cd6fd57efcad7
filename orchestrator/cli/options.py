"""Options that several commands share, and reading what they name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from friction_models.loads import DataSet

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


def named_entries(models: Sequence[str], names: Path | None) -> dict[str, dict[str, Any]]:
    """Return what the file behind `--names` says of each model."""
    if names is None:
        return {}
    from ..friction_names import entries_by_model

    return entries_by_model(models, names)


def any_model(name: str, entries: Mapping[str, Any] | None = None) -> Any:
    """Return what `--model` names: a model folder, a friction FMU, an ONNX file, a number (constant mu) or a family.

    Parameters
    ----------
    name : str
    entries : mapping, optional
        What `named_entries` returned.

    Raises
    ------
    InputError
        None of them; the message holds the nearest family.
    """
    path = Path(name)
    if path.suffix == ".fmu":
        from ..foreign_friction import friction_model

        return friction_model(path, (entries or {}).get(name))
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
            f"{name}: no such model; allowed: a model folder, an .fmu or .onnx file or a model family"
        )
    return named_model(name)


def fitted_model(name: str, entries: Mapping[str, Any] | None = None) -> Any:
    """Return the model behind a name as `any_model` does; it must be able to predict."""
    model = None if Path(name).suffix == ".onnx" else any_model(name, entries)
    if model is None or not model.is_fitted:
        from friction_models.loads import InputError

        raise InputError(
            f"{name}: {'an ONNX file' if model is None else 'the name of a family, not a trained model'}; "
            "allowed: a model folder, an .fmu file or a number"
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
