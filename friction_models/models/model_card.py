"""The model card: what a model is, what it was trained on, how well it does, where it holds."""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping
from functools import cache
from importlib import metadata
from typing import TYPE_CHECKING, Any

from ..loads import LOADS
from .intervals import SD_OFFSET, SIGMA_OFFSET, V_OFFSET

if TYPE_CHECKING:
    from .law import FrictionLaw

PACKAGES = ("numpy", "scikit-learn", "torch", "onnx")


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


def build_card(model: FrictionLaw) -> dict[str, Any]:
    """Return the card of a fitted model as a JSON-able dict."""
    model.require_fitted()
    training: Mapping[str, Any] = getattr(model, "training_", {})
    untrained: dict[str, Any] = {"points": 0, "tests": None, "synthetic": None, "provenance": {}}
    splits = dict(training.get("splits", {}))
    if hasattr(model, "validation_tests_"):
        splits["validation"] = list(model.validation_tests_)
    return {
        "name": model.name,
        "family": model.family,
        "formula": model.formula_text(),
        "parameters": model._plain_params(),
        "data": dict(training.get("data", untrained)),
        "splits": splits,
        "errors": dict(getattr(model, "errors_", {})),
        "domain": model.domain.to_dict(),
        "states": [s.to_dict() for s in model.states],
        "system_variables": [s.to_dict() for s in model.system_variables],
        "versions": dict(training.get("versions", versions())),
    } | ({} if model.interval is None else {"interval": model.interval.summary()})


def tied_loads(data: Mapping[str, Any]) -> str:
    """Say which loads the training data, the part `data` of a card, do not tell apart; empty where there are none."""
    names = data.get("not_told_apart", ())
    if not names:
        return ""
    return (
        f"{', '.join(names[:-1])} and {names[-1]} follow from one another in the training data but for rounding: their "
        "influences cannot be told apart, and where they do not go together the model is a guess"
    )


def _labels(variable: Mapping[str, Any]) -> str:
    """Say which number stands for which label; empty for a number."""
    shown = ", ".join(f"{k} = {label}" for k, label in enumerate(variable.get("labels", ())))
    return f"; {shown}, any other number: none of these" if shown else ""


def _interval_lines(interval: Mapping[str, Any]) -> list[str]:
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
        "- Outside the domain: the margin at the nearest point of the domain, times (1 + distance); no coverage is promised",
    ]
    if interval["coverage"]:
        lines += [
            *(
                "",
                "| role | expected | within (each test alike) | 95 % interval of it | worst test | mean width | tests |",
            ),
            "|---|---|---|---|---|---|---|",
        ]
    for role, c in interval["coverage"].items():
        lines.append(
            f"| {role} | {c['expected']:.1%} | {c['share']:.1%} | {c['share_low']:.1%} to {c['share_high']:.1%} "
            f"| {c['worst_test']:.0%} | {c['mean_width']:.4f} | {c['tests']:g} |"
        )
    return lines


def card_text(card: Mapping[str, Any]) -> str:
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
    lines += [f"- {key}: {value}" for key, value in data.get("provenance", {}).items()]
    lines += [f"- Parameter {key}: {value}" for key, value in card["parameters"].items()]
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
    for title, key in (("Internal states", "states"), ("System variables", "system_variables")):
        if card[key]:
            lines += ["", f"## {title}", ""]
            lines += [f"- {v['name']} [{v['unit']}], start {v['start']:g}{_labels(v)}" for v in card[key]]
    train = splits.get("train")
    if train:
        listed = ", ".join(train) if isinstance(train, list) else f"{train} tests"
        lines += ["", "## Split", "", f"By whole tests. Trained on: {listed}"]
        if splits.get("validation"):
            lines.append(f"Of these, held out to stop the training: {', '.join(splits['validation'])}")
    lines += ["", "## Versions", ""] + [f"- {k} {v}" for k, v in card["versions"].items()]
    return "\n".join(lines) + "\n"
