"""Feed-forward neural networks. Only training needs torch (extra `train-networks`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ..common import InputError, unknown_name
from ..expressions.ops import LoadColumns, NumpyOps, Ops, Value
from ..expressions.parameters import check_integer, check_number, check_seed, stored_floats
from ..expressions.scaling import Scaling
from ..loads import LOAD_NAMES, FloatArray, TriboLoads
from ..loads.splits import hold_out
from ..models.base import FrictionModel, LoadsLike
from ..models.domain import Domain
from ..models.intervals.between_levels import Widening
from ..models.law import Arrays, Groups, JsonObject, Learned, States, System, Weights
from .network import Lesson, Masks, TrainingOptions, train_networks

ACTIVATIONS = ("tanh", "relu", "sigmoid")
#: Fewest tests held out by the networks from which a prediction interval is taken without training again.
ENOUGH_LEFT_OUT = 40
MAX_LAYERS, MAX_WIDTH, MAX_MEMBERS = 8, 1024, 64
#: Offsets that keep the logarithms of the inputs regular at zero loads: mm/s, MPa, mm.
V_OFFSET, SIGMA_OFFSET, SD_OFFSET = 10.0, 200.0, 2.0


@dataclass(eq=False, repr=False)
class FeedForwardFriction(FrictionModel):
    """mu = mean of a few feed-forward networks of the five loads.

    The inputs are ``log(v_rel + 10), T, log(sigma_n + 200), log(sd + 2), log(psi)``, standardised: plans
    step speed, pressure and expansion over decades, and between such steps a network interpolates more
    safely on a logarithmic scale. Each network holds out tests of its own, stops when the error on them
    no longer falls and keeps its best epoch; the mean of the networks scatters less between the levels
    of a plan than any of them. The same seed and data give the same weights on the same machine.

    Parameters
    ----------
    hidden : sequence of int
        Width of each hidden layer.
    members : int
        Number of networks.
    activation : {"tanh", "relu", "sigmoid"}
    learning_rate : float
        Of Adam at the start; it falls along a half cosine to a hundredth.
    batch_size : int
        Most points a step; small data sets take smaller batches, so that an epoch has about 40 steps.
    epochs : int
        Most epochs.
    patience : int
        Epochs without a better held-out error of any network before training stops.
    weight_decay : float
        Penalty on squared weights (decoupled, as in AdamW).
    validation_fraction : float
        Share of the tests each network holds out; 0, or fewer than four tests, trains all epochs.
    seed : int
    threads : int
        Threads of torch while training; 1 makes runs repeatable and parallel studies fast.

    Attributes
    ----------
    networks_ : list of list of (ndarray, ndarray)
        Weights (in, out) and biases (out,) of every layer of every network, float64; scaling of mu is in
        the last layer.
    scaling_ : Scaling
        Of the five inputs.
    epochs_ : list of int
        Epochs until the weights that were kept.
    validation_tests_ : list of str
        Tests that at least one network held out.

    Examples
    --------
    >>> from friction_models import FeedForwardFriction
    >>> model = FeedForwardFriction(hidden=(8, 8), members=2, seed=1)
    >>> model.get_params()["hidden"], model.is_fitted
    ((8, 8), False)
    >>> model.predict([[50, 20, 500, 0, 1]])
    Traceback (most recent call last):
        ...
    friction_models.models.law.UnfittedError: the ffnn model is not fitted; call fit or fit_frame first
    """

    family: ClassVar[str] = "ffnn"

    hidden: Sequence[int] = (16, 16)
    members: int = 4
    activation: str = "tanh"
    learning_rate: float = 5e-3
    batch_size: int = 512
    epochs: int = 80
    patience: int = 20
    weight_decay: float = 1.0
    validation_fraction: float = 0.2
    seed: int = 0
    threads: int = 1

    def _check_params(self) -> list[int]:
        """Check all parameters; return the widths of all layers, input and output included."""
        if self.activation not in ACTIVATIONS:
            raise unknown_name("activation", self.activation, ACTIVATIONS, self.family)
        check_number(self.family, "learning_rate", self.learning_rate, 1e-7, 1.0)
        check_number(self.family, "weight_decay", self.weight_decay, 0.0, 100.0)
        check_number(self.family, "validation_fraction", self.validation_fraction, 0.0, 0.9)
        check_integer(self.family, "members", self.members, 1, MAX_MEMBERS)
        check_integer(self.family, "batch_size", self.batch_size, 1, 10**7)
        check_integer(self.family, "epochs", self.epochs, 1, 10**6)
        check_integer(self.family, "patience", self.patience, 1, 10**6)
        check_seed(self.family, self.seed)
        check_integer(self.family, "threads", self.threads, 1, 1024)
        if not isinstance(self.hidden, (list, tuple)) or not 1 <= len(self.hidden) <= MAX_LAYERS:
            raise InputError(
                f"{self.family}: hidden is {self.hidden!r:.60}, allowed: 1 to {MAX_LAYERS} widths"
            )
        widths = [check_integer(self.family, "hidden", w, 1, MAX_WIDTH) for w in self.hidden]
        return [len(LOAD_NAMES), *widths, 1]

    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups, sample_weight: Weights = None) -> None:
        _train_together([self], [(loads, mu, groups, sample_weight)])

    def _lesson(self, loads: TriboLoads, mu: FloatArray, groups: Groups, sample_weight: Weights) -> Lesson:
        """Return what the networks learn from; notes the scaling and the tests held out."""
        x = NumpyOps()
        features = x.concat(_inputs(x, LoadColumns.from_matrix(x, loads.as_array())))
        self.scaling_ = Scaling.of(features)
        held = self._held_out(groups, len(mu))
        self.validation_tests_ = (
            [] if groups is None else sorted(set(groups[np.logical_or.reduce(held)].tolist()))
        )
        outputs = Scaling.of(mu[:, None]).apply(mu[:, None])
        inputs = self.scaling_.apply(features)
        return Lesson(inputs, outputs, held, self.seed, self.weight_decay, sample_weight)

    def _held_out(self, groups: Groups, points: int) -> Masks:
        """Return which points each network holds out."""
        seeds = range(self.seed, self.seed + self.members)
        return [hold_out(groups, points, self.validation_fraction, seed)[1] for seed in seeds]

    @property
    def _options(self) -> TrainingOptions:
        """What models must share to be trained in one batch."""
        return TrainingOptions(
            tuple(self._check_params()),
            self.activation,
            self.learning_rate,
            self.batch_size,
            self.epochs,
            self.patience,
            self.threads,
        )

    def formula(self, x: Ops, L: LoadColumns, S: States = None, system: System = None) -> Value:
        total: Value = 0.0
        for value in self._each(x, L):
            total = total + value
        return total * (1.0 / len(self.networks_))

    def _each(self, x: Ops, L: LoadColumns) -> Iterator[Value]:
        """Yield mu of each network, [n, 1]."""
        activation = {"tanh": x.tanh, "relu": x.relu, "sigmoid": x.sigmoid}[self.activation]
        inputs = x.concat(self.scaling_.columns(x, _inputs(x, L)))
        for network in self.networks_:
            value = x.matmul(inputs, *network[0])
            for layer in network[1:]:
                value = x.matmul(activation(value), *layer)
            yield value

    def left_out(
        self, loads: TriboLoads, mu: FloatArray, groups: npt.NDArray[np.str_], folds: int, seed: int
    ) -> tuple[FloatArray, str]:
        """Return mu from the networks that held the test of a point out while they learned; see `FrictionModel`.

        Nothing is trained again. The mean of fewer networks scatters more than the model itself, which errs on the safe
        side. Where too few tests were held out, there are folds as for any other model.
        """
        held = self._held_out(groups, len(mu))
        count = np.sum(held, axis=0)
        if len(np.unique(groups[count > 0])) < ENOUGH_LEFT_OUT:
            return super().left_out(loads, mu, groups, folds, seed)
        x = NumpyOps()
        total = np.zeros(len(mu))
        for own, value in zip(held, self._each(x, LoadColumns.from_matrix(x, loads.as_array()))):
            total[own] += np.maximum(value[own, 0], 0.0)
        predicted = np.where(count > 0, total / np.maximum(count, 1), np.nan)
        return predicted, "tests that networks held out to stop their training"

    def between_levels(
        self, loads: TriboLoads, mu: FloatArray, groups: npt.NDArray[np.str_], predicted: FloatArray
    ) -> tuple[Widening, ...]:
        """Return nothing: networks would be trained anew without each level."""
        return ()

    def formula_text(self) -> str:
        count = sum(w.size + b.size for network in self.networks_ for w, b in network)
        layers = "-".join(str(w) for w in (len(LOAD_NAMES), *self.hidden, 1))
        many = len(self.networks_)
        what = "network" if many == 1 else f"mean of {many} networks"
        return f"mu = {what} {layers} ({self.activation}, {count} weights) of the loads"

    def _learned(self) -> Learned:
        arrays = self.scaling_.arrays()
        for k, network in enumerate(self.networks_):
            for i, (weights, bias) in enumerate(network):
                arrays |= {f"weights{k}_{i}": weights, f"biases{k}_{i}": bias}
        return {"epochs": self.epochs_, "validation_tests": self.validation_tests_}, arrays

    def _restore(self, values: JsonObject, arrays: Arrays) -> None:
        self.hidden = tuple(self.hidden) if isinstance(self.hidden, list) else self.hidden
        shapes = list(pairwise(self._check_params()))
        self.networks_ = [
            [
                (
                    stored_floats(self.family, arrays, f"weights{k}_{i}", shape),
                    stored_floats(self.family, arrays, f"biases{k}_{i}", shape[1:]),
                )
                for i, shape in enumerate(shapes)
            ]
            for k in range(self.members)
        ]
        self.scaling_ = Scaling.restore(self.family, arrays, len(LOAD_NAMES))
        self.epochs_ = [check_integer(self.family, "epochs", e, 0, 10**6) for e in values["epochs"]]
        self.validation_tests_ = [str(t) for t in values.get("validation_tests", [])]


def fit_together(
    models: Sequence[FeedForwardFriction],
    data: Sequence[tuple[LoadsLike, npt.ArrayLike, npt.ArrayLike | None]],
) -> None:
    """Fit each model to its own data, as `fit` does, with those of one shape trained in one batched product.

    Lessons of equal length give the networks that `fit` gives, to rounding; see `families.network.train_networks`.

    `data` has the arguments of `fit` (loads, mu, groups) of each model; what `fit` refuses is refused here, too.
    """
    checked = [model._checked(*own) for model, own in zip(models, data, strict=True)]
    weights = [model._weights(*own, None) for model, own in zip(models, checked)]
    batches: dict[TrainingOptions, list[int]] = {}
    for number, model in enumerate(models):
        batches.setdefault(model._options, []).append(number)
    for batch in batches.values():
        _train_together([models[k] for k in batch], [(*checked[k], weights[k].points) for k in batch])
    for model, own, weighed in zip(models, checked, weights):
        model.domain_ = Domain.of(own[0])
        model._record_fit(*own, weighed)


def _train_together(
    models: Sequence[FeedForwardFriction], data: Sequence[tuple[TriboLoads, FloatArray, Groups, Weights]]
) -> None:
    """Train models that are alike; mu's scaling goes into the last layers."""
    options = models[0]._options
    lessons = [model._lesson(*own) for model, own in zip(models, data)]
    for model, (_, mu, _, _), (networks, epochs) in zip(models, data, train_networks(lessons, options)):
        target = Scaling.of(mu[:, None])
        for network in networks:
            weights, bias = network[-1]
            network[-1] = (weights * target.scale, bias * target.scale + target.mean)
        model.networks_, model.epochs_ = networks, epochs


def _inputs(x: Ops, L: LoadColumns) -> list[Value]:
    """Return the five inputs of the networks, before standardisation."""
    return [
        x.log(L.v_rel + V_OFFSET),
        L.T,
        x.log(L.sigma_n + SIGMA_OFFSET),
        x.log(L.sd + SD_OFFSET),
        x.log(L.psi),
    ]
