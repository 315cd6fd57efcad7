"""The model card: law, training data, errors and trained domain of a model; which tests it has seen in training."""

from __future__ import annotations

import hashlib
import math
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from typing import Any, NotRequired, TypedDict

import numpy as np
import numpy.typing as npt

from ..common.json_values import JsonObject
from ..common.wording import counted
from ..loads import LOADS, POINT_UNITS, FloatArray
from ..loads.contract import behind
from .effective_variance import HonouredUncertainty, honoured_sentence
from .intervals.features import SD_OFFSET, SIGMA_OFFSET, V_OFFSET
from .intervals.prediction_interval import LEAST_TESTS, IntervalNumbers
from .measures import Measures, loads_sentence

PACKAGES = ("numpy", "scikit-learn", "torch", "onnx")
#: Significant digits of mu that count in a hash of a test: a CSV file may change the last ones.
DIGITS = 9
#: Of so many tests the names and hashes are kept; of more their number.
LISTED_TESTS = 1000


class DataFacts(TypedDict):
    """What a card says of the training data; None where it is not recorded."""

    points: int
    tests: int | None
    synthetic: bool | None
    provenance: dict[str, str | int | float]
    not_told_apart: NotRequired[list[str]]
    load_uncertainty: NotRequired[HonouredUncertainty]


#: Of a law that was never fitted to data.
UNTRAINED: DataFacts = {"points": 0, "tests": None, "synthetic": None, "provenance": {}}


class Splits(TypedDict, total=False):
    """Names of the tests, or their number where they are many; hashes by test, see `test_digests`."""

    by: str
    train: int | list[str]
    digests: dict[str, str]
    validation: list[str]


class Training(TypedDict, total=False):
    """What a model was trained on."""

    data: DataFacts
    splits: Splits
    versions: dict[str, str]


class ModelCard(TypedDict):
    """The card of a fitted model, as `card.json` and the ONNX file hold it."""

    name: str
    family: str
    formula: str
    parameters: dict[str, object]
    data: DataFacts
    splits: Splits
    errors: dict[str, Measures]
    domain: dict[str, list[float] | None]
    states: list[JsonObject]
    system_variables: list[JsonObject]
    versions: dict[str, str]
    interval: NotRequired[IntervalNumbers]
    refinement: NotRequired[list[JsonObject]]


@cache
def package_version(name: str) -> str | None:
    """Return the version of an installed distribution, or None."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def versions() -> dict[str, str]:
    """Return the versions that a training depends on."""
    found = {name: package_version(name) for name in ("tribofmu", *PACKAGES)}
    return {"python": platform.python_version()} | {k: v for k, v in found.items() if v is not None}


def trained_on_synthetic(card: Any) -> bool:
    """Return whether a card, of ours or of others, says that its model was trained on synthetic data."""
    data = card.get("data") if isinstance(card, Mapping) else None
    return isinstance(data, Mapping) and bool(data.get("synthetic"))


def tied_loads(data: DataFacts) -> str:
    """Say which loads the training data, the part `data` of a card, do not tell apart; empty where there are none."""
    names = data.get("not_told_apart", ())
    if not names:
        return ""
    return (
        f"{', '.join(names[:-1])} and {names[-1]} follow from one another in the training data but for rounding: their "
        "influences cannot be told apart, and where they do not go together the model is a guess"
    )


def few_tests(data: DataFacts) -> str:
    """Say that the errors of training mean little, where there are too few tests for an interval; empty else."""
    tests = data["tests"]
    if tests is None or tests >= LEAST_TESTS:
        return ""
    return f"trained on {counted(tests, 'test')} ({counted(data['points'], 'point')}): the errors above say nothing about new tests"


def _labels(variable: JsonObject) -> str:
    """Say which number stands for which label; empty for a number."""
    shown = ", ".join(f"{k} = {label}" for k, label in enumerate(variable.get("labels", ())))
    return f"; {shown}, any other number: none of these" if shown else ""


def _interval_lines(interval: IntervalNumbers) -> list[str]:
    """Return the section on the prediction interval."""
    how = {
        "conformal": "quantile of the errors, every test counted alike, corrected for one test more",
        "student": "Student's t over the tests, which are too few for a quantile",
    }
    slopes = ", ".join(f"{name} {value:+.4g}" for name, value in interval["slopes"].items() if value)
    if slopes:
        margin = (
            f"{interval['factor']:.4g} exp({interval['constant']:.4g} + sum of slope x feature), with the slopes {slopes}; the "
            f"features are T, log(v_rel + {V_OFFSET:g}), log(sigma_n + {SIGMA_OFFSET:g}), log(sd + {SD_OFFSET:g}), log(psi)"
        )
    else:
        margin = f"{interval['factor'] * math.exp(interval['constant']):.4g} everywhere in the domain"
    lines = [
        *("", "## Prediction interval", ""),
        f"Holds {100.0 * interval['level']:g} % of the points of new tests: mu +- margin, cut at 0.",
        "",
        f"- From the errors of {interval['tests']} whole tests ({interval['points']} points): {interval['source']}",
        f"- Method: {interval['method']} ({how.get(interval['method'], 'not recorded')})",
        f"- Margin: {margin}",
        *_between_lines(interval),
        "- Outside the domain: the margin at the nearest point of the domain, times (1 + distance); no coverage is promised",
    ]
    if interval["coverage"]:
        lines += [
            "",
            "| role | expected | within (each test alike) | 95 % interval of it | worst test | mean width | tests |",
            "|---|---|---|---|---|---|---|",
        ]
    for role, c in interval["coverage"].items():
        lines.append(
            f"| {role} | {c['expected']:.1%} | {c['share']:.1%} | {c['share_low']:.1%} to {c['share_high']:.1%} "
            f"| {c['worst_test']:.0%} | {c['mean_width']:.4f} | {c['tests']:g} |"
        )
    return lines


def _between_lines(interval: IntervalNumbers) -> list[str]:
    """Return what is added to the margin between the levels of a plan; none where nothing is."""
    gaps = [
        f"{w['extra']:.2g} at {w['load']} {w['low']:.4g} to {w['high']:.4g}{behind(POINT_UNITS[w['load']])}"
        for w in interval.get("between", ())
        if w["extra"]
    ]
    if not gaps:
        return []
    return [
        f"- Between the levels of the plan more, in the middle by {', '.join(gaps)}: so much a fit without a level misses that level"
    ]


def _setting(value: Any) -> str:
    """Return a parameter as one reads it: of a base its family, of effects their names, each with the numbers that are set."""
    if isinstance(value, list) and any(isinstance(v, dict) for v in value):
        return ", ".join(map(_setting, value))
    if not isinstance(value, dict):
        return str(value)
    numbers = next((v for v in value.values() if isinstance(v, dict)), {})
    names = " ".join(str(v) for v in value.values() if not isinstance(v, dict))
    return names + (f" ({', '.join(f'{k} = {v}' for k, v in numbers.items())})" if numbers else "")


def card_text(card: ModelCard) -> str:
    """Return the card as Markdown."""
    data, splits = card["data"], card["splits"]
    label = {True: "SYNTHETIC (virtual laboratory)", False: "measured", None: "not recorded"}
    tests = data.get("tests")
    lines = [
        f"# Friction model: {card['name']}",
        "",
        "Coefficient of friction as a function of the five tribological loads.",
        "",
        f"- Law: `{card['formula']}`",
        f"- Family: {card['family']}",
        f"- Training data: {data.get('points', 0)} points" + (f" of {tests} whole tests" if tests else ""),
        f"- Origin of the data: {label.get(data.get('synthetic'), 'not recorded')}",
    ]
    tied = tied_loads(data)
    lines += [f"- Warning: {tied}"] if tied else []
    honoured = data.get("load_uncertainty")
    lines += [f"- {honoured_sentence(honoured, data.get('points', 0))}"] if honoured else []
    lines += [f"- {key}: {value}" for key, value in data.get("provenance", {}).items()]
    lines += [f"- Parameter {key}: {_setting(value)}" for key, value in card["parameters"].items()]
    lines += ["", "## Errors", ""]
    if card["errors"]:
        lines += [
            "| split | MAE | RMSE | bias | worst test MAE | points | tests |",
            "|---|---|---|---|---|---|---|",
        ]
        for split, e in card["errors"].items():
            worst = f"{e['mae_worst_test']:.5f}" if "mae_worst_test" in e else ""
            lines.append(
                f"| {split} | {e['mae']:.5f} | {e['rmse']:.5f} | {e['bias']:+.5f} | {worst} "
                f"| {e['points']:g} | {e.get('tests', '')} |"
            )
        parts = [(split, e.get("rms_from_loads"), e["rmse"]) for split, e in card["errors"].items()]
        said = [
            f"- {split}: {loads_sentence(a, b)}" for split, a, b in parts if a is not None and b is not None
        ]
        lines += ["", *said] if said else []
        lines += [
            "",
            "`train` is the error on the data the model was fitted to; judge a model by tests held out.",
        ]
    else:
        lines.append("None recorded: the model was not fitted to data.")
    if "interval" in card:
        lines += _interval_lines(card["interval"])
    lines += ["", "## Domain", "", "| load | meaning | from | to | unit |", "|---|---|---|---|---|"]
    for q in LOADS:
        limits = card["domain"][q.name]
        shown = ("not measured", "no influence") if limits is None else (f"{x:.6g}" for x in limits)
        lines.append(f"| {q.name} | {q.meaning} | {' | '.join(shown)} | {q.unit} |")
    lines += ["", "Outside this range the model extrapolates; mu is never negative."]
    for title, variables in (
        ("Internal states", card["states"]),
        ("System variables", card["system_variables"]),
    ):
        if variables:
            lines += ["", f"## {title}", ""]
            lines += [f"- {v['name']} [{v['unit']}], start {v['start']:g}{_labels(v)}" for v in variables]
    train = splits.get("train")
    if train:
        listed = ", ".join(train) if isinstance(train, list) else counted(train, "test")
        lines += ["", "## Split", "", f"By whole tests. Trained on: {listed}"]
        if splits.get("validation"):
            lines.append(f"Of these, held out to stop the training: {', '.join(splits['validation'])}")
    lines += ["", "## Versions", ""] + [f"- {k} {v}" for k, v in card["versions"].items()]
    return "\n".join(lines) + "\n"


def test_digests(tests: npt.ArrayLike, mu: FloatArray) -> dict[str, str]:
    """Return a short hash of the measured mu of each test, whatever the order of its points.

    Examples
    --------
    The order of the points does not matter:

    >>> one = test_digests(["a", "a", "b"], np.array([0.08, 0.07, 0.06]))
    >>> one == test_digests(["b", "a", "a"], np.array([0.06, 0.07, 0.08]))
    True
    """
    names, test = np.unique(np.asarray(tests).astype(str), return_inverse=True)
    found = {}
    for k, name in enumerate(names.tolist()):
        values = ",".join(f"{x:.{DIGITS}g}" for x in np.sort(mu[test == k]).tolist())
        found[name] = hashlib.sha256(values.encode()).hexdigest()[:12]
    return found


@dataclass(frozen=True)
class Seen:
    """Tests that a model is judged by and was trained on.

    Examples
    --------
    >>> Seen(["a", "b"], judged=5, checked=True).sentence("linear")
    'linear was trained on 2 of the 5 tests that it is judged by: errors there say little about new tests'
    """

    tests: list[str]
    #: Number of all tests that it is judged by.
    judged: int
    #: Whether the values agree, too; cards of earlier versions hold the names only.
    checked: bool

    def sentence(self, model: str) -> str:
        """Return what to know about the errors of the model."""
        count = len(self.tests)
        how_many = f"{'all' if count == self.judged else f'{count} of the'} {self.judged} tests"
        if self.judged == 1:
            how_many = "the only test"
        what = how_many if self.checked else f"tests with the names of {how_many}"
        return f"{model} was trained on {what} that it is judged by: errors there say little about new tests"


def seen_in_training(model: Any, tests: npt.ArrayLike, mu: FloatArray) -> Seen | None:
    """Return which of these tests a model was trained on, as its card says; None where it has none, or names none of them.

    `tests` is the test of each point, `mu` what was measured there, as it stands in the data; both of shape (n,).
    """
    return seen_by_card(getattr(model, "card", None), test_digests(tests, mu))


def seen_by_card(card: object, digests: Mapping[str, str]) -> Seen | None:
    """Return which tests, by their `test_digests`, a card names as those of the training; None where it names none of them."""
    splits = card.get("splits") if isinstance(card, Mapping) else None
    trained = splits.get("train") if isinstance(splits, Mapping) else None
    if not isinstance(splits, Mapping) or not isinstance(trained, list):
        return None
    known = splits.get("digests")
    checked = isinstance(known, Mapping)
    names = {str(t) for t in trained} & set(digests)
    if isinstance(known, Mapping):
        names = {t for t in names if known.get(t) == digests[t]}
    return Seen(sorted(names), len(digests), checked) if names else None
