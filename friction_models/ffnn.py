"""Feed-forward neural network: trained with torch, evaluated without it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, ClassVar

import numpy.typing as npt

from .base import FrictionModel, Groups
from .loads import LOAD_NAMES, FloatArray, InputError, TriboLoads, unknown_name
from .ops import LoadColumns, Ops, Value
from .parameters import check_integer, check_number, stored_floats
from .scaling import Scaling
from .training.splits import hold_out

ACTIVATIONS = ("tanh", "relu", "sigmoid")
MAX_LAYERS, MAX_WIDTH = 8, 1024


class FeedForwardFriction(FrictionModel):
    """mu = feed-forward network of the five standardised loads.

    Training stops when the error on whole held-out tests no longer falls, and the weights of the best
    epoch are kept. The same seed and data give the same weights on the same machine.

    Parameters
    ----------
    hidden : sequence of int
        Width of each hidden layer.
    activation : {"tanh", "relu", "sigmoid"}
    learning_rate : float
        Of Adam at the start; it falls along a half cosine to a hundredth.
    batch_size : int
        Most points a step; small data sets take smaller batches, so that an epoch has about 40 steps.
    epochs : int
        Most epochs.
    patience : int
        Epochs without a better held-out error before training stops.
    weight_decay : float
        Penalty on squared weights (decoupled, as in AdamW).
    validation_fraction : float
        Share of the tests held out; 0, or fewer than four tests, trains all epochs.
    seed : int
    threads : int
        Threads of torch while training; 1 makes runs repeatable and parallel studies fast.

    Attributes
    ----------
    weights_, biases_ : list of ndarray
        Shapes (in, out) and (out,), float64; scaling of mu is in the last layer.
    scaling_ : Scaling
    epochs_ : int
        Epochs until the best weights.
    validation_tests_ : list of str
    """

    family: ClassVar[str] = "ffnn"

    def __init__(
        self,
        hidden: Sequence[int] = (32, 32),
        activation: str = "tanh",
        learning_rate: float = 5e-3,
        batch_size: int = 512,
        epochs: int = 200,
        patience: int = 30,
        weight_decay: float = 1e-3,
        validation_fraction: float = 0.2,
        seed: int = 0,
        threads: int = 1,
    ) -> None:
        self.hidden = hidden
        self.activation = activation
        self.learning_rate = learning_rate
        self.batch_size = batch_size
        self.epochs = epochs
        self.patience = patience
        self.weight_decay = weight_decay
        self.validation_fraction = validation_fraction
        self.seed = seed
        self.threads = threads

    def _check_params(self) -> list[int]:
        """Check all parameters; return the widths of all layers, input and output included."""
        if self.activation not in ACTIVATIONS:
            raise unknown_name("activation", self.activation, ACTIVATIONS, self.family)
        check_number(self.family, "learning_rate", self.learning_rate, 1e-7, 1.0)
        check_number(self.family, "weight_decay", self.weight_decay, 0.0, 1.0)
        check_number(self.family, "validation_fraction", self.validation_fraction, 0.0, 0.9)
        check_integer(self.family, "batch_size", self.batch_size, 1, 10**7)
        check_integer(self.family, "epochs", self.epochs, 1, 10**6)
        check_integer(self.family, "patience", self.patience, 1, 10**6)
        check_integer(self.family, "seed", self.seed, 0, 2**32 - 1)
        check_integer(self.family, "threads", self.threads, 1, 1024)
        if not isinstance(self.hidden, (list, tuple)) or not 1 <= len(self.hidden) <= MAX_LAYERS:
            raise InputError(
                f"{self.family}: hidden is {self.hidden!r:.60}, allowed: 1 to {MAX_LAYERS} widths"
            )
        widths = [check_integer(self.family, "hidden", w, 1, MAX_WIDTH) for w in self.hidden]
        return [len(LOAD_NAMES), *widths, 1]

    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups) -> None:
        from .training.network import train_network

        widths = self._check_params()
        matrix = loads.as_array()
        train, held = hold_out(groups, len(mu), self.validation_fraction, self.seed)
        self.validation_tests_ = [] if groups is None else sorted(set(groups[held].tolist()))
        self.scaling_ = Scaling.of(matrix[train])
        target = Scaling.of(mu[train, None])
        inputs, outputs = self.scaling_.apply(matrix), target.apply(mu[:, None])
        weights, biases, self.epochs_ = train_network(
            (inputs[train], outputs[train]), (inputs[held], outputs[held]), widths, self
        )
        weights[-1] = weights[-1] * target.scale
        biases[-1] = biases[-1] * target.scale + target.mean
        self.weights_, self.biases_ = weights, biases

    def formula(
        self,
        x: Ops,
        L: LoadColumns,
        S: Sequence[Value] | None = None,
        system: Mapping[str, Value] | None = None,
    ) -> Value:
        activation = {"tanh": x.tanh, "relu": x.relu, "sigmoid": x.sigmoid}[self.activation]
        # Standardisation is folded into the first layer.
        first = self.weights_[0] / self.scaling_.scale[:, None]
        value = x.matmul(x.concat(L.columns()) - self.scaling_.mean[None, :], first, self.biases_[0])
        for weights, bias in zip(self.weights_[1:], self.biases_[1:]):
            value = x.matmul(activation(value), weights, bias)
        return value

    def formula_text(self) -> str:
        count = sum(w.size + b.size for w, b in zip(self.weights_, self.biases_))
        layers = "-".join(str(w) for w in (len(LOAD_NAMES), *self.hidden, 1))
        return f"mu = network {layers} ({self.activation}, {count} weights) of the standardised loads"

    def _learned(self) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
        layers = {f"weights{i}": w for i, w in enumerate(self.weights_)}
        layers |= {f"biases{i}": b for i, b in enumerate(self.biases_)}
        values = {"epochs": self.epochs_, "validation_tests": self.validation_tests_}
        return values, layers | self.scaling_.arrays()

    def _restore(self, values: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        self.hidden = tuple(self.hidden) if isinstance(self.hidden, list) else self.hidden
        widths = self._check_params()
        shapes = list(pairwise(widths))
        self.weights_ = [stored_floats(self.family, arrays, f"weights{i}", s) for i, s in enumerate(shapes)]
        self.biases_ = [
            stored_floats(self.family, arrays, f"biases{i}", (s[1],)) for i, s in enumerate(shapes)
        ]
        self.scaling_ = Scaling.restore(self.family, arrays, len(LOAD_NAMES))
        self.epochs_ = check_integer(self.family, "epochs", values["epochs"], 0, 10**6)
        self.validation_tests_ = [str(t) for t in values.get("validation_tests", [])]
