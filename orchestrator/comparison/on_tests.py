"""Several friction models on the same tribometer tests: errors, and what they predict at every point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt
import pandas as pd

from friction_models.common import InputError
from friction_models.discovery.comparison import Comparison, compare
from friction_models.discovery.resampling import resampled
from friction_models.estimation.campaign.binning import prepare
from friction_models.loads import LOAD_NAMES, MU, DataSet, FloatArray, TriboLoads
from friction_models.models.domain import known_domain
from friction_models.models.measures import range_warning

from .order import REPLICATES, Order

#: How the columns with mu of a model begin in tables of points.
OF = "mu of "


class Predictor(Protocol):
    """Anything that predicts mu; a `domain` is used where there is one."""

    def predict(self, loads: FloatArray, /) -> FloatArray: ...

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> npt.ArrayLike: ...


@dataclass(frozen=True)
class TestsComparison:
    """Models on tribometer tests."""

    __test__ = False  # not a test, whatever pytest thinks of its name

    result: Comparison  # errors with their intervals
    order: Order  # by RMSE
    outside: dict[str, float | None]  # share of the points outside the trained domain; None: not known
    loads: TriboLoads = field(repr=False)  # at the points
    mu: FloatArray = field(repr=False)  # measured at the points
    #: By model; loads outside a model's trained domain were moved to its border, as its FMU does by default, but for
    #: models with memory.
    predicted: dict[str, FloatArray] = field(repr=False)
    models: Mapping[str, Predictor] = field(repr=False)  # for response curves
    synthetic: bool = False

    def to_dict(self) -> dict[str, object]:
        """Return JSON-able data: that of `Comparison`, and the order."""
        content = self.result.to_dict()
        for name, entry in content["models"].items():
            entry["outside_domain"] = self.outside[name]
            entry["probability_best"] = self.order.best[name] if self.order.judged else None
            entry["rank_interval"] = self.order.rank(name)
        return content | {"order": self.order.to_dict(), "remarks": self.remarks()}

    def points(self) -> pd.DataFrame:
        """Return one row a point: test, loads, measured mu, and mu of each model in a column ``mu of NAME``."""
        ids = self.loads.test_id
        columns: dict[str, object] = {"test_id": [""] * len(self.mu) if ids is None else ids.astype(str)}
        columns |= {name: getattr(self.loads, name) for name in LOAD_NAMES}
        columns |= {MU.name: self.mu} | {f"{OF}{name}": self.predicted[name] for name in self.models}
        return pd.DataFrame(columns)

    def remarks(self) -> list[str]:
        """Return a sentence for each model that was trained on the tests, and for each whose mu cannot be one."""
        return [*self.result.remarks(), *self._moved(), *self._out_of_range(), *self._constants()]

    def _constants(self) -> list[str]:
        """Say what a bare number is in a list of models."""
        names = [n for n in self.order.names if n.replace(".", "", 1).isdigit()]
        said = "the same coefficient of friction at every load; nothing was fitted"
        return [f"{', '.join(names)}: {said}"] if names else []

    def _moved(self) -> list[str]:
        """Say for which models loads were moved, since `evaluate` does not do that and finds other errors."""
        names = [n for n in self.order.names if self.outside[n] and not _left_alone(self.models[n])]
        if not names:
            return []
        said = "loads outside the trained domain are moved to its border, as in the FMU; `evaluate` lets a model folder extrapolate"
        return [f"{', '.join(names)}: {said}"]

    def _out_of_range(self) -> list[str]:
        found = []
        for name in self.order.names:
            warning = range_warning(self.predicted[name])
            if warning:
                hint = "; are its units right (--names)?" if _is_fmu(self.models[name]) else ""
                found.append(f"{name}: {warning}{hint}")
        return found

    def report(self) -> str:
        """Return a text table, best model first, and what can be said about the order."""
        width = max(len(n) for n in self.order.names)
        lines = [self.result.report().rstrip("\n"), ""]
        lines.append(f"{'model':<{width}}  probability best      place  outside its domain")
        for name in self.order.names:
            place = self.order.place(name)
            share = self.outside[name]
            said = "not known" if share is None else f"{100 * share:.1f} %"
            lines.append(f"{name:<{width}}  {self.order.chance(name):>16}  {place:>9}  {said}")
        return "\n".join([*lines, *self.order.sentences(), *self._moved(), *self._out_of_range()]) + "\n"


def _left_alone(model: Predictor) -> bool:
    """Whether loads stay as they are: an FMU moves them itself, and memory needs distance and speed as they are."""
    return _is_fmu(model) or bool(getattr(model, "states", None))


class _Kept:
    """A model within its trained domain, as in its FMU, that remembers what it predicted last."""

    def __init__(self, name: str, model: Predictor) -> None:
        self.name = name
        self.model = model
        self.card = getattr(model, "card", None)
        self.domain = None if _left_alone(model) else known_domain(model)
        self.values: FloatArray = np.empty(0)

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> FloatArray:
        """Return what the model predicts; a failure names the model."""
        if self.domain is not None:
            loads = TriboLoads.from_frame(data)
            inside = pd.DataFrame(self.domain.clamp(loads.as_array()), data.index, list(LOAD_NAMES))
            data = data.assign(**{n: inside[n] for n in LOAD_NAMES if n not in loads.absent})
        try:
            self.values = np.asarray(self.model.predict_frame(data, tests), dtype=float).ravel()
        except InputError:
            raise
        except RuntimeError as error:  # an FMU that refuses a value
            raise InputError(f"model {self.name!r} cannot be evaluated: {error}") from None
        return self.values


def compare_on_tests(models: Mapping[str, Predictor], data: DataSet, seed: int = 0) -> TestsComparison:
    """Compare models on the held-out tests of a data set, or on all where none is held out; `seed` is that of the resampling.

    Examples
    --------
    Three tests in which mu is 0.1; two constants are compared on them:

    >>> import pandas as pd
    >>> from friction_models import ConstantFriction
    >>> one = {"v_rel": 20.0, "T": 80.0, "sigma_n": 600.0, "psi": 2.0, "mu": 0.1}
    >>> points = pd.DataFrame([{"test_id": t, "sd": sd, **one} for t in "abc" for sd in (0.0, 1.0, 2.0)])
    >>> models = {"0.12": ConstantFriction(0.12), "0.11": ConstantFriction(0.11)}
    >>> found = compare_on_tests(models, DataSet(points))
    >>> found.order.names, round(found.result.errors["0.12"].rmse, 6)
    (['0.11', '0.12'], 0.02)
    """
    held_out = data.select("test")
    used = held_out if len(held_out.points) else data
    kept = {str(name): _Kept(str(name), model) for name, model in models.items()}
    result = compare(kept, used.points, used.tests, seed)
    campaign = prepare(used.points, used.tests)
    predicted = {name: item.values for name, item in kept.items()}
    group, tests = campaign.point_test, len(campaign.tests)
    errors = {name: mu - campaign.mu for name, mu in predicted.items()}
    resamples = resampled(errors, group, np.random.default_rng(seed), REPLICATES)
    draws = {name: found.rmse for name, found in resamples.items()}
    order = Order.of({n: e.rmse for n, e in result.errors.items()}, draws, tests)
    # The head line says no more than the table of pairs below it.
    result = replace(result, clear=len(order.names) > 1 and tuple(order.names[:2]) not in order.indistinct)
    array = campaign.as_read.as_array()  # as `evaluate` counts them
    outside: dict[str, float | None] = {}
    for name, model in models.items():
        domain = known_domain(model)
        inside = None if domain is None else domain.without(campaign.absent).contains(array)
        outside[str(name)] = None if inside is None else float(np.mean(~inside))
    return TestsComparison(
        result, order, outside, campaign.loads, campaign.mu, predicted, models, bool(data.synthetic)
    )


def _is_fmu(model: Predictor) -> bool:
    return getattr(model, "family", "") == "fmu"
