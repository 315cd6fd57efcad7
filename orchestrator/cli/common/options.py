"""Options that several commands share, and reading what they name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from friction_models.common import InputError, nearest
from friction_models.common.processes.child_processes import environment
from friction_models.common.wording import counted, first_names

from .console import note
from .files_named import Reads, Writes

if TYPE_CHECKING:
    from fmus.runtime.foreign_friction import GivenNames
    from friction_models.loads import DataSet

    from ...cosim.system import System

#: What tests are for; another role is allowed, and judged by itself.
ROLES = ("train", "test")
Data = Annotated[
    Path, typer.Option("--data", help="Data set: a folder with points.csv, or a CSV or Parquet file.")
]
Tests = Annotated[
    Path | None, typer.Option("--tests", help="Test table (one row a test), where --data is a single file.")
]
OutFolder = Annotated[Path, typer.Option("-o", "--out", help="Folder to write.")]
OutFile = Annotated[Path, typer.Option("-o", "--out", help="File to write."), Writes()]
Json = Annotated[
    Path | None, typer.Option("--json", help="Also write the result to this JSON file."), Writes()
]
Report = Annotated[
    list[Path] | None,
    typer.Option(
        "--report",
        "--export",
        "--pdf",
        help="Also write a report: .html, .pdf (printed by a browser), or .xlsx (its tables); may be given several times.",
    ),
    Writes("PAGE"),
]
NextTests = Annotated[
    Path | None,
    typer.Option("--plan", help="Also write the proposed tests as a plan (CSV, one row a test)."),
    Writes(),
]
Names = Annotated[
    Path | None,
    typer.Option(
        "--names", help="YAML file: which variables of FMUs that others made take the loads and give mu."
    ),
]
Swap = Annotated[
    list[str] | None,
    typer.Option(
        "--swap",
        help="Run another model in a component: friction=FILE.fmu; for friction also a model folder, card:NAME, an .onnx file or a number.",
    ),
    Reads(),
]


def _isolated(context: typer.Context, value: bool | None) -> bool | None:
    """Apply the option to this command and the processes that it starts."""
    if value is not None:
        context.with_resource(environment(**{ISOLATE: str(int(value))}))
    return value


#: `fmus.archive.made_here.VARIABLE`, which is not imported here for the sake of time.
ISOLATE = "TRIBOFMU_ISOLATE"
Isolate = Annotated[
    bool | None,
    typer.Option(
        "--isolate/--no-isolate",
        callback=_isolated,
        help="Run all FMUs in processes of their own, where a crash does no harm, or none; by default those not made here.",
    ),
]
FittedModel = Annotated[
    str,
    typer.Argument(help="Model folder, .fmu or .onnx file, card:NAME, or a number for constant mu."),
    Reads(),
]
Jobs = Annotated[
    int | None, typer.Option("--jobs", "-j", min=1, help="Processes to use (default: all cores).")
]


def read_data(
    data: Path,
    tests: Path | None = None,
    models: Iterable[Any] = (),
    every_load: bool = False,
    **how: bool,
) -> DataSet:
    """Read the data set behind `--data` and `--tests`; say what was left out, what was not measured, and what the models do not know.

    For `models` with memory the points must have an order, and metadata that they were not trained with is named; with `every_load` all five loads must be measured; `how` as
    `DataSet.load` has it.
    """
    from friction_models.loads import DataSet, not_measured, require_every_load

    dataset = DataSet.load(data, tests, **how)
    if every_load:
        require_every_load(dataset.points.columns, str(data))
    laws = [law for m in models for law in (m, getattr(m, "source", None))]
    if any(getattr(law, "states", ()) for law in laws):
        dataset.require_order()
    lacking = not_measured(dataset.points.columns)
    notes = [f"{data}: {', '.join(lacking)} not measured"] if lacking else []
    # What a map is calibrated by has a meaning of its own and stands in no table of tests.
    variables = [
        v
        for law in laws
        for v in getattr(law, "system_variables", getattr(law, "system", ()))
        if not getattr(v, "meaning", "")
    ]
    if variables:
        from friction_models.models.unknown_metadata import metadata_remarks

        found = metadata_remarks(variables, dataset.tests, dataset.points["test_id"].unique())
        notes += [f"{data}: {remark}" for remark in dict.fromkeys(found)]
    for text in (*notes, *_misspelt_roles(dataset, data), *_unmatched(dataset, data), *dataset.notes):
        note(text)
    return dataset


def _misspelt_roles(dataset: DataSet, where: object) -> list[str]:
    """Return notes about roles that look like ``train`` or ``test``: each is a role of its own, on which nothing is trained."""
    if dataset.tests is None or "role" not in dataset.tests.columns:
        return []
    from friction_models.loads.dataset import roles_of

    counts = roles_of(dataset.tests["role"]).value_counts(sort=False)
    return [
        f"{where}: role {role!r} of {counted(int(tests), 'test')} is none of {', '.join(ROLES)}; did you mean {meant!r}? Nothing is trained on these"
        for role, tests in counts.items()
        if role not in ROLES and (meant := nearest(str(role), ROLES))
    ]


def _unmatched(dataset: DataSet, where: object) -> list[str]:
    """Return notes about tests of the table that have no points, and points whose tests the table lacks."""
    if dataset.tests is None:
        return []
    listed, measured = (frame["test_id"].astype(str) for frame in (dataset.tests, dataset.points))
    empty = listed[~listed.isin(measured)].tolist()
    unlisted = measured[~measured.isin(listed)].unique().tolist()
    notes = []
    if empty:
        notes.append(
            f"{where}: {counted(len(empty), 'test')} of the table without points ({first_names(empty)})"
        )
    if unlisted:
        notes.append(
            f"{where}: {counted(len(unlisted), 'test')} without a row in the table of tests ({first_names(unlisted)}): for "
            "training, and nothing else is known of them"
        )
    return notes


def learning_part(dataset: DataSet, where: object) -> DataSet:
    """Return the tests that a model may learn from, one at least; those that are held out stay unseen."""
    part = dataset.select("train")
    if part.points.empty and not dataset.points.empty and dataset.tests is not None:
        from friction_models.loads.dataset import roles_of

        found = first_names(sorted(set(roles_of(dataset.tests["role"]))))
        raise InputError(
            f"{where}: no test has the role 'train', the table holds {found}; allowed: at least one (tribofmu tests DATA "
            "--set TEST:role=train), or one without a role"
        )
    return part


def swapped(system: System, swap: Iterable[str] | None, names: Path | None = None) -> System:
    """Return the system with other models in the components that `--swap` names; `--names` says how their variables are called."""
    from ...cosim.swapping import swap_model

    pairs = [split_pair("--swap ", item, "component=FILE.fmu") for item in swap or []]
    twice = [name for name, number in Counter(name for name, _ in pairs).items() if number > 1]
    if twice:
        models = " and ".join(repr(model) for name, model in pairs if name == twice[0])
        raise InputError(f"--swap: component {twice[0]!r} is given {models}; allowed: one model each")
    given = given_names([model for _, model in pairs], names)
    for component, model in pairs:
        system = swap_model(
            system, component, model, given.foreign(model) if model in given.entries else None
        )
    return system


def named_model(name: str, parameters: Iterable[str] = ()) -> Any:
    """Return the unfitted model of a family; `parameters` are ``key=value``."""
    from friction_models.families.registry import make_model

    return make_model(name, **key_values(parameters))


def given_names(models: Sequence[str], names: Path | None) -> GivenNames:
    """Return what the file behind `--names` says of the models."""
    from fmus.runtime.foreign_friction import GivenNames

    return GivenNames.read(models, names)


#: What can predict, for messages.
_FITTED = "a model folder, an .fmu or .onnx file, card:NAME"


def any_model(name: str, names: GivenNames | None = None) -> Any:
    """Return what `--model` names: a model folder, a friction FMU, an ONNX file, a card, a number (constant mu) or a family."""
    model = _given_model(name, names)
    if model is not None:
        return model
    path = Path(name)
    if "/" in name or "\\" in name or path.suffix:
        raise InputError(
            f"{name}: no such model; allowed: {_FITTED}, a number or a model family{_near(path)}"
        )
    return named_model(name)


def fitted_model(name: str, names: GivenNames | None = None) -> Any:
    """Return the model behind a name as `any_model` does, but none of a family: it must be able to predict."""
    model = _given_model(name, names)
    if model is None:
        from friction_models.families.registry import FAMILIES

        found = "the name of a family, not a trained model" if name in FAMILIES else "no such model"
        raise InputError(f"{name}: {found}; allowed: {_FITTED} or a number{_near(Path(name))}")
    return model


def _given_model(name: str, names: GivenNames | None) -> Any:
    """Return the model in a file or folder, of a card, or of a number; None where the name is none of these."""
    from friction_models.cards import is_card

    if is_card(name):
        from friction_models.cards import load_card

        return load_card(name).model()
    path = Path(name)
    if path.suffix == ".fmu":
        from fmus.runtime.foreign_friction import GivenNames

        model = (names or GivenNames()).open(name)
        if model.remark():
            note(model.remark())
        return model
    if path.suffix == ".onnx":
        from friction_models.models.onnx_model import OnnxModel

        return OnnxModel(path)
    if path.is_dir():
        from friction_models import load_model

        return load_model(path)
    number = as_number(name)
    if number is None:
        return None
    from friction_models import ConstantFriction

    return ConstantFriction(number)


def _near(path: Path) -> str:
    """Return "did you mean" with the nearest name beside a missing path."""
    if path.exists():  # something else that is no model
        return ""
    beside = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
    hint = nearest(path.name, beside)
    return f"; did you mean {str(path.parent / hint)!r}?" if hint else ""


def as_number(text: str) -> float | None:
    """Return the number that a text is, or None."""
    try:
        return float(text)
    except ValueError:
        return None


def split_pair(option: str, text: str, form: str) -> tuple[str, str]:
    """Return what is before and behind the first equals sign; the error says which `form` is allowed."""
    name, _, value = text.partition("=")
    if not value.strip():
        raise InputError(f"{option}{text!r}: not of the form {form}")
    return name, value


def key_values(pairs: Iterable[str], texts: Collection[str] = ()) -> dict[str, Any]:
    """Read ``key=value`` texts; values as YAML reads them, except those of the keys in `texts`."""
    import yaml

    from friction_models.common.yaml_files import number_without_point

    result = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key:
            raise InputError(f"{pair!r}: not of the form key=value")
        if key in result:
            raise InputError(f"{pair[:80]!r}: {key} is set twice; allowed: once")
        try:
            result[key] = value if key in texts else number_without_point(yaml.safe_load(value))
        except (yaml.YAMLError, ValueError, RecursionError):
            raise InputError(
                f"{pair[:80]!r}: the value cannot be read; allowed: a number or a name"
            ) from None
    return result
