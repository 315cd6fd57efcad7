"""Several friction models on the same tribometer tests: errors, and how sure their order is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Protocol, TypedDict

import numpy as np
import numpy.typing as npt
import pandas as pd

from friction_models.common import InputError
from friction_models.discovery.comparison import Comparison, compare
from friction_models.discovery.resampling import FEWEST_TESTS, SAME, resampled
from friction_models.estimation.campaign.binning import prepare
from friction_models.loads import LOAD_NAMES, MU, DataSet, FloatArray, TriboLoads
from friction_models.models.domain import known_domain
from friction_models.models.measures import range_warning

#: Resampled sets of tests, and how sure an order has to be.
REPLICATES = 4000
SURE = 0.95
#: How the columns with mu of a model begin in tables of points.
OF = "mu of "
#: With fewer tests or levels than this no two models are told apart, as none is clearly ahead.
FEWEST_UNITS = FEWEST_TESTS


class Predictor(Protocol):
    """Anything that predicts mu; a `domain` is used where there is one."""

    def predict(self, loads: FloatArray, /) -> FloatArray: ...

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> npt.ArrayLike: ...


class Pair(TypedDict):
    """Two models."""

    better: str
    worse: str
    difference: float  # by which the error of the worse one is larger
    interval: list[float]  # of the difference, 95 %
    probability: float  # that the better one is better indeed
    apart: bool  # whether they can be told apart


@dataclass(frozen=True)
class Order:
    """How sure the order of models is, from resampling whole tests (or press levels) for all models alike.

    Examples
    --------
    >>> errors = {"a": 0.010, "b": 0.020}
    >>> draws = {"a": np.array([0.009, 0.011, 0.010]), "b": np.array([0.019, 0.021, 0.010])}
    >>> order = Order.of(errors, draws, units=3)
    >>> order.names, round(order.best["a"], 3), order.indistinct
    (['a', 'b'], 0.833, [('a', 'b')])
    """

    names: list[str]  # best first
    best: dict[str, float]  # probability of being the best of all
    ranks: dict[str, tuple[int, int]]  # 95 % interval of the place, 1 is the best
    pairs: list[Pair]
    units: int  # number of tests or levels

    @classmethod
    def of(
        cls, errors: Mapping[str, float], draws: Mapping[str, FloatArray], units: int, same: float = SAME
    ) -> Order:
        """Order models by an error.

        `errors` are those of each model, smaller is better; `draws` the same in every resampled set, all models in
        the same sets; `units` is the number of tests or levels that were resampled. Errors that differ by less than
        the share `same` of theirs count as equal.
        """
        names = sorted(errors, key=lambda n: errors[n])
        table = np.array([draws[n] for n in names])
        # The same law in two files differs by rounding and by what the solver resolves, which decides nothing.
        places = 1 + (table[:, None, :] > (1.0 + same) * table[None, :, :]).sum(axis=1)
        first = (table <= (1.0 + same) * table.min(axis=0)).astype(float)
        best = (first / first.sum(axis=0)).mean(axis=1)
        low, high = np.quantile(places, [0.025, 0.975], axis=1, method="nearest")
        pairs: list[Pair] = []
        tail = 0.5 * (1.0 - SURE)
        for i, j in combinations(range(len(names)), 2):
            change = table[j] - table[i]
            resolved = same * float(np.max(table[[i, j]]))
            interval = np.quantile(change, [tail, 1.0 - tail]).tolist()
            pairs.append(
                {
                    "better": names[i],
                    "worse": names[j],
                    "difference": errors[names[j]] - errors[names[i]],
                    "interval": interval,
                    "probability": float(
                        np.mean(change > resolved) + 0.5 * np.mean(np.abs(change) <= resolved)
                    ),
                    "apart": bool(interval[0] > resolved and units >= FEWEST_UNITS),
                }
            )
        ranks = {n: (int(a), int(b)) for n, a, b in zip(names, low, high)}
        return cls(names, dict(zip(names, best.tolist())), ranks, pairs, units)

    @property
    def judged(self) -> bool:
        """Whether there are enough tests (or levels) for an order of models."""
        return self.units >= FEWEST_UNITS

    def chance(self, name: str) -> str:
        """Return how probably a model is the best of all, in words."""
        return f"{100 * self.best[name]:.0f} %" if self.judged else "not known"

    def place(self, name: str, to: str = "-") -> str:
        """Return the 95 % interval of the place of a model, in words."""
        low, high = self.ranks[name]
        if not self.judged and len(self.names) > 1:
            return "not known"
        return f"{low}" if low == high else f"{low}{to}{high}"

    @property
    def indistinct(self) -> list[tuple[str, str]]:
        """Pairs that cannot be told apart."""
        return [(p["better"], p["worse"]) for p in self.pairs if not p["apart"]]

    def sentences(self, unit: str = "tests") -> list[str]:
        """Return what can be said about the order."""
        if len(self.names) < 2:
            return []
        lines = []
        pairs = self.indistinct
        if pairs:
            shown = ", ".join(f"{a} and {b}" for a, b in pairs[:6]) + (
                f" and {len(pairs) - 6} more pairs" if len(pairs) > 6 else ""
            )
            words = f"{self.units} {unit}" if self.units != 1 else f"1 {unit.removesuffix('s')}"
            lines.append(f"cannot be told apart on {words}: {shown}")
        if not self.judged:
            lines.append(self._too_few(unit))
        return lines

    def _too_few(self, unit: str) -> str:
        return f"at least {FEWEST_UNITS} {unit} are needed to tell models apart"

    def to_dict(self, unit: str = "tests") -> dict[str, object]:
        """Return JSON-able data; where the order is not known its numbers are None, and ``reason`` says why."""
        return {
            "units": self.units,
            "best": {n: self.best[n] if self.judged else None for n in self.names},
            "ranks": {n: self.rank(n) for n in self.names},
            "pairs": [p if self.judged else {**p, "interval": None, "probability": None} for p in self.pairs],
            "indistinct": [list(p) for p in self.indistinct],
            "reason": None if self.judged else self._too_few(unit),
        }

    def rank(self, name: str) -> list[int] | None:
        """Return the 95 % interval of the place of a model; None where it is not known."""
        return list(self.ranks[name]) if self.judged or len(self.names) == 1 else None


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
    array = campaign.loads.as_array()
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


def resampled_errors(
    simulated: Sequence[FloatArray], measured: FloatArray, deviation: FloatArray, rng: np.random.Generator
) -> list[FloatArray]:
    """Return the mean absolute relative error of each model in resampled sets of press levels.

    Levels are drawn with replacement, and the measured mean of each is drawn from its own uncertainty, the
    standard deviation of the repeats over the root of their number; all models in the same sets. All arrays have the
    shape (levels,): `simulated` one a model, `measured` the mean of the repeats, `deviation` that of this mean.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> measured = np.array([100.0, 200.0])
    >>> (errors,) = resampled_errors([1.1 * measured], measured, 0.0 * measured, rng)
    >>> round(float(errors.min()), 6), round(float(errors.max()), 6)
    (0.1, 0.1)
    """
    levels = len(measured)
    chosen = rng.integers(0, levels, (REPLICATES, levels))
    drawn = measured[chosen] + deviation[chosen] * rng.standard_normal((REPLICATES, levels))
    drawn = np.where(np.abs(drawn) < 1e-9, 1e-9, drawn)
    return [np.asarray(np.mean(np.abs(s[chosen] / drawn - 1.0), axis=1)) for s in simulated]
