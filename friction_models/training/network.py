"""Training of a small fully connected network with torch."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..loads import FloatArray

if TYPE_CHECKING:
    from ..ffnn import FeedForwardFriction

#: Fewest steps an epoch, where the data set has enough points for batches of the smallest size.
STEPS = 40
SMALLEST_BATCH = 32

Sample = tuple[FloatArray, FloatArray]


def train_network(
    train: Sample, held: Sample, widths: list[int], options: FeedForwardFriction
) -> tuple[list[FloatArray], list[FloatArray], int]:
    """Minimise the mean squared error; keep the weights that are best on the held-out sample.

    Parameters
    ----------
    train, held : tuple of ndarray
        Standardised inputs (n, widths[0]) and outputs (n, 1); `held` may be empty: then the last weights stay.
    widths : list of int
        Width of every layer, input and output included.
    options : FeedForwardFriction
        Its parameters steer the training.

    Returns
    -------
    weights, biases : list of ndarray, float64
        Shapes (in, out) and (out,).
    epochs : int
        Epochs until these weights.
    """
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(options.threads)
    try:
        rng = np.random.default_rng(options.seed)
        weights = [
            torch.tensor(rng.uniform(-1, 1, (a, b)) * math.sqrt(6 / (a + b)), requires_grad=True)
            for a, b in pairwise(widths)
        ]
        biases = [torch.zeros(b, dtype=torch.float64, requires_grad=True) for b in widths[1:]]
        activation = {"tanh": torch.tanh, "relu": torch.relu, "sigmoid": torch.sigmoid}[options.activation]

        def predict(value: torch.Tensor) -> torch.Tensor:
            for weight, bias in zip(weights[:-1], biases[:-1]):
                value = activation(torch.addmm(bias, value, weight))
            return torch.addmm(biases[-1], value, weights[-1])

        parameters: list[dict[str, Any]] = [{"params": weights}, {"params": biases, "weight_decay": 0.0}]
        optimizer = torch.optim.AdamW(
            parameters,
            lr=options.learning_rate,
            weight_decay=options.weight_decay,
            fused=True,
        )
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(
            optimizer, options.epochs, options.learning_rate * 1e-2
        )
        inputs, outputs = (torch.from_numpy(np.ascontiguousarray(a)) for a in train)
        held_inputs, held_outputs = (torch.from_numpy(np.ascontiguousarray(a)) for a in held)
        batch = min(options.batch_size, max(SMALLEST_BATCH, math.ceil(len(inputs) / STEPS)))
        best, best_epoch, kept = math.inf, 0, [p.detach().clone() for p in (*weights, *biases)]
        for epoch in range(1, options.epochs + 1):
            order = torch.from_numpy(rng.permutation(len(inputs)))
            for rows in order.split(batch):
                optimizer.zero_grad(set_to_none=True)
                loss = torch.nn.functional.mse_loss(predict(inputs[rows]), outputs[rows])
                loss.backward()
                optimizer.step()
            schedule.step()
            if len(held_inputs):
                with torch.no_grad():
                    error = float(torch.nn.functional.mse_loss(predict(held_inputs), held_outputs))
            else:
                error = -float(epoch)
            if error < best:
                best, best_epoch, kept = error, epoch, [p.detach().clone() for p in (*weights, *biases)]
            elif epoch - best_epoch >= options.patience:
                break
        arrays = [p.numpy().copy() for p in kept]
        return arrays[: len(weights)], arrays[len(weights) :], best_epoch
    finally:
        torch.set_num_threads(threads)
