"""`train`, `evaluate`, `predict`: friction models on data sets."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .console import say, show, table, write_result
from .options import Data, Json, OutFile, OutFolder, Tests, fitted_model, named_model, read_data

if TYPE_CHECKING:
    from ..evaluation import Evaluation


def train(
    family: Annotated[
        str,
        typer.Argument(
            help="Model family: constant, linear, polynomial, power_law, gradient_boosting, ffnn.",
            metavar="MODEL",
        ),
    ],
    data: Data,
    out: OutFolder,
    tests: Tests = None,
    parameters: Annotated[
        list[str] | None, typer.Option("--set", help="Parameter of the family, for example degree=2.")
    ] = None,
) -> None:
    """Train a friction model on the tests of the role `train` and save it with its model card."""
    model = named_model(family, parameters or [])
    dataset = read_data(data, tests)
    part = dataset.select("train")
    _refuse_empty(len(part.points), data)
    model.fit_frame(part.points, part.tests, info=part.info)
    result = _evaluate_into(model, dataset)
    model.save(out)
    _print_roles(f"{family}: errors of mu", result, dataset.synthetic)
    say(f"model written: {out}")


def evaluate(
    model: Annotated[str, typer.Argument(help="Model folder, .fmu file, or a number for constant mu.")],
    data: Data,
    tests: Tests = None,
    worst: Annotated[int, typer.Option(help="How many of the worst tests to list.")] = 10,
    json: Json = None,
) -> None:
    """Show the errors of a model: overall, by role (train, test) and test by test."""
    from ..evaluation import evaluate as measure

    friction = fitted_model(model)
    dataset = read_data(data, tests)
    result = measure(friction, dataset)
    _print_roles(f"{model}: errors of mu", result, dataset.synthetic)
    listed = table(
        "worst tests", {"test": "left", "role": "left", "rms": "right", "bias": "right", "outside": "right"}
    )
    for row in result.tests.head(worst).to_dict(orient="records"):
        listed.add_row(
            row["test_id"],
            row["role"],
            f"{row['rmse']:.4f}",
            f"{row['bias']:+.4f}",
            f"{100 * row['outside']:.0f} %",
        )
    show(listed)
    if json is not None:
        content = {"model": model, "data": str(data), "synthetic": dataset.synthetic, **result.to_dict()}
        write_result(json, content)


def predict(
    model: Annotated[str, typer.Argument(help="Model folder, .fmu file, or a number for constant mu.")],
    data: Data,
    out: OutFile,
    tests: Tests = None,
) -> None:
    """Write the points with a further column `mu_model` (CSV or Parquet by the suffix of the output)."""
    from friction_models.loads import InputError, atomic_path

    if out.suffix not in {".csv", ".parquet"}:
        raise InputError(f"{out}: suffix {out.suffix!r}, allowed: .csv, .parquet")
    friction = fitted_model(model)
    dataset = read_data(data, tests, need_mu=False)
    frame = dataset.points.assign(mu_model=friction.predict_frame(dataset.points, dataset.tests))
    with atomic_path(out) as temporary:
        if out.suffix == ".csv":
            frame.to_csv(temporary, index=False, lineterminator="\n")
        else:
            frame.to_parquet(temporary, index=False)
    say(f"written: {out} ({len(frame)} points)")


def _evaluate_into(model: Any, dataset: Any) -> Evaluation:
    """Evaluate, and keep the errors of the held-out tests on the model's card."""
    from ..evaluation import evaluate as measure

    result = measure(model, dataset)
    if "test" in result.roles:
        model.record_errors("test", result.roles["test"])
    return result


def _print_roles(title: str, result: Evaluation, synthetic: bool) -> None:
    note = " (synthetic data)" if synthetic else ""
    columns = {"tests": "right", "points": "right", "MAE": "right", "RMS": "right", "bias": "right"}
    listed = table(title + note, {"role": "left", **columns, "worst test (MAE)": "right"})
    for role, errors in result.roles.items():
        listed.add_row(
            role,
            f"{errors.get('tests', 0)}",
            f"{errors['points']}",
            f"{errors['mae']:.4f}",
            f"{errors['rmse']:.4f}",
            f"{errors['bias']:+.4f}",
            f"{errors.get('mae_worst_test', float('nan')):.4f}",
        )
    show(listed)


def _refuse_empty(points: int, data: Path) -> None:
    if points == 0:
        from friction_models.loads import InputError

        raise InputError(f"{data}: no test has the role 'train'; allowed: at least one")


def add_commands(app: typer.Typer) -> None:
    """Register the commands of this file."""
    app.command(epilog="Example: tribofmu train polynomial --data data --set degree=2 -o models/polynomial")(
        train
    )
    app.command(epilog="Example: tribofmu evaluate models/polynomial --data data --json errors.json")(
        evaluate
    )
    app.command(epilog="Example: tribofmu predict models/polynomial --data data -o predicted.csv")(predict)
