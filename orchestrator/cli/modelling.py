"""`train`, `evaluate`, `predict`: friction models on data sets."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .console import say, write_result
from .options import Data, Json, OutFile, OutFolder, Tests, fitted_model, named_model, read_data


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
    _refuse_empty(len(dataset.select("train").points), data)
    from friction_models.training import train as fit

    result = fit(model, dataset)
    model.save(out)
    say(result.report())
    say(f"model written: {out}")


def evaluate(
    model: Annotated[str, typer.Argument(help="Model folder, .fmu file, or a number for constant mu.")],
    data: Data,
    tests: Tests = None,
    json: Json = None,
) -> None:
    """Show the errors of a model: overall, by role (train, test) and test by test."""
    from friction_models import evaluate as measure

    friction = fitted_model(model)
    result = measure(friction, read_data(data, tests), name=model)
    say(result.report())
    if json is not None:
        write_result(json, {"data": str(data), **result.to_dict()})


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
