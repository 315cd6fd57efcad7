"""`train`, `evaluate`, `predict`: friction models on data sets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from friction_models.common import InputError
from friction_models.common.wording import first_names, listed

from ..common.console import note, say, write_result
from ..common.files_named import Commands, Writes
from ..common.options import (
    Data,
    FittedModel,
    Isolate,
    Json,
    Names,
    OutFile,
    OutFolder,
    Tests,
    fitted_model,
    given_names,
    learning_part,
    named_model,
    read_data,
)

if TYPE_CHECKING:
    from friction_models.cards import Card
    from friction_models.loads import DataSet
    from friction_models.training import Evaluation

app = Commands(rich_markup_mode="rich")


Interval = Annotated[
    bool,
    typer.Option(
        "--interval/--no-interval",
        help="Calibrate a prediction interval for mu on tests left out (at least 4 tests).",
    ),
]
Level = Annotated[
    float | None,
    typer.Option(
        help="Share of the points of new tests that the prediction interval is to hold, 0.5 to 0.999 (default: that of "
        "the model)."
    ),
]
HonourLoads = Annotated[
    bool,
    typer.Option(
        "--load-uncertainty/--ignore-load-uncertainty",
        help="Honour standard uncertainties of the loads (columns u_sigma_n, u_psi, u_T): points whose loads are uncertain "
        "weigh less.",
    ),
]


@app.command(epilog="Example: tribofmu train polynomial --data data --set degree=2 -o models/polynomial")
def train(
    family: Annotated[
        str,
        typer.Argument(
            help="Model family: constant, linear, polynomial, power_law, gradient_boosting, ffnn.",
            metavar="MODEL",
        ),
    ],
    data: Data,
    out: Annotated[OutFolder, Writes("MODEL")],
    tests: Tests = None,
    parameters: Annotated[
        list[str] | None, typer.Option("--set", help="Parameter of the family, for example degree=2.")
    ] = None,
    interval: Interval = True,
    level: Annotated[
        float | None,
        typer.Option(
            help="Share of the points of new tests that the prediction interval is to hold (default: 0.95)."
        ),
    ] = None,
    load_uncertainty: HonourLoads = True,
    card: Annotated[
        str | None,
        typer.Option("--from", help="Card as prior knowledge for few tests: card:NAME."),
    ] = None,
    prior_tests: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            help="How many tests the card weighs as much as (default: from its uncertainty and the scatter of yours).",
        ),
    ] = None,
) -> None:
    """Train a friction model on the tests of the role `train` and save it with its model card."""
    model = named_model(family, parameters or [])
    dataset = read_data(data, tests)
    learning_part(dataset, data)
    if not load_uncertainty:
        dataset = dataset.without_load_uncertainty()
    from friction_models.models.effective_variance import honoured_sentence
    from friction_models.models.intervals.prediction_interval import check_level
    from friction_models.models.model_card import few_tests, tied_loads
    from friction_models.training import train as fit

    if level is not None:
        check_level(level)
        if card is not None or not interval:
            raise InputError(
                f"--level {level:g}: no prediction interval is calibrated; allowed: without --no-interval and --from"
            )
    if card is None and prior_tests is not None:
        raise InputError("--prior-tests: weighs a card; allowed: with --from card:NAME")
    if card is not None:
        from friction_models.cards import load_card

        # Copies that are fitted without a test would be fitted without the card, too: no interval.
        result, weight = _from_card(model, dataset, load_card(card), prior_tests)
        said = f"prior: card {load_card(card).name}, as much as {weight:.3g} tests; no prediction interval with a prior\n"
    else:
        result = fit(model, dataset)
        said = add_interval(model, dataset, level) if interval else ""
    model.save(out)
    say(result.report())
    facts = model.card["data"]
    if "load_uncertainty" in facts:
        say(honoured_sentence(facts["load_uncertainty"], facts["points"]))
    if said:
        say(said)
    for remark in (few_tests(facts), tied_loads(facts)):
        if remark:
            note(remark)
    say(f"model written: {out}")


def _from_card(model: Any, dataset: DataSet, card: Card, tests: float | None) -> tuple[Evaluation, float]:
    """Fit with a card as prior and measure as `friction_models.training.train` does."""
    from friction_models.cards import fit_from_card
    from friction_models.training import evaluate as measure

    chosen = dataset.select("train")
    loads = chosen.loads()
    weight = fit_from_card(model, card, loads, chosen.points["mu"].to_numpy(float), loads.test_id, tests)
    evaluation = measure(model, dataset)
    for role, measures in evaluation.roles.items():
        model.record_errors(role, measures)
    return evaluation, weight


def add_interval(model: Any, dataset: DataSet, level: float | None = None) -> str:
    """Calibrate the prediction interval of a fitted model; return what to tell the user, also why there is none."""
    from friction_models.families.refinement_history import left_out_tests
    from friction_models.models.intervals.prediction_interval import LEVEL
    from friction_models.training.interval_coverage import add_interval as calibrate
    from friction_models.training.interval_coverage import not_measured, report

    left_out = left_out_tests(model)
    try:
        interval = calibrate(model, dataset, LEVEL if level is None else level)
    except InputError as error:
        said = f"no prediction interval: {error}\n"
    else:
        said = report(interval) + not_measured(
            dataset.without_tests(left_out), {w.load for w in interval.between}
        )
    return said + (f"(without {first_names(left_out)}, as the fit)\n" if left_out else "")


@app.command(epilog="Example: tribofmu evaluate models/polynomial --data data --json errors.json")
def evaluate(
    model: FittedModel,
    data: Data,
    tests: Tests = None,
    json: Json = None,
    level: Level = None,
    names: Names = None,
    isolate: Isolate = None,
) -> None:
    """Show the errors of a model: overall, by role (train, test) and test by test; and what its interval holds."""
    from friction_models import evaluate as measure

    friction = fitted_model(model, given_names([model], names))
    dataset = read_data(data, tests, [friction])
    _refuse_level(friction, model, level)
    result = measure(friction, dataset, name=model)
    say(result.report())
    content = {"data": str(data), **result.to_dict()}
    if has_interval(friction):
        from friction_models.training.interval_coverage import coverage_text, measured_coverage

        content["coverage"] = coverage = measured_coverage(friction, dataset, level)
        say(coverage_text(coverage))
    write_result(json, content)


@app.command(epilog="Example: tribofmu predict models/polynomial --data data -o predicted.csv")
def predict(
    model: FittedModel,
    data: Data,
    out: OutFile,
    tests: Tests = None,
    level: Level = None,
    names: Names = None,
    isolate: Isolate = None,
) -> None:
    """Write the points with the column `mu_model` and, from a model with a prediction interval, `mu_low` and `mu_high`.

    The output is CSV or Parquet, by its suffix: the rows and columns of the input as they stand in it.
    """
    from friction_models.loads.table import write_table
    from friction_models.models.measures import range_warning

    if out.suffix not in {".csv", ".parquet"}:
        raise InputError(f"{out}: suffix {out.suffix!r}, allowed: .csv, .parquet")
    friction = fitted_model(model, given_names([model], names))
    _refuse_level(friction, model, level)
    dataset = read_data(data, tests, [friction], need_mu=False, keep_given=True)
    predicted = {"mu_model": friction.predict_frame(dataset.points, dataset.tests).to_numpy()}
    if has_interval(friction):
        bounds = friction.predict_interval_frame(dataset.points, dataset.tests, level)
        predicted |= {str(bound.name): bound.to_numpy() for bound in bounds}
    frame = dataset.as_given(**predicted)
    if earlier := [name for name in predicted if name in dataset.points.columns]:
        note(f"{data}: the predictions there ({listed(earlier)}) are replaced in {out} by those of {model}")
    write_table(out, frame)
    say(f"written: {out} ({len(frame)} points)")
    if warning := range_warning(predicted["mu_model"]):
        say(warning)


def has_interval(model: Any) -> bool:
    """Whether a model knows a prediction interval."""
    return getattr(model, "interval_level", None) is not None


def _refuse_level(model: Any, name: str, level: float | None) -> None:
    """Refuse a level that is none, or of a model without an interval, before anything is said."""
    if level is None:
        return
    from friction_models.models.intervals.prediction_interval import check_level

    check_level(level)
    if not has_interval(model):
        raise InputError(
            f"--level {level:g}: {name} has no prediction interval; allowed: a model trained with one (train --interval)"
        )
