"""Training of several small fully connected networks at once with torch."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..loads import FloatArray

if TYPE_CHECKING:
    import torch

    from ..ffnn import FeedForwardFriction

Masks = list[npt.NDArray[np.bool_]]
#: Weights (in, out) and biases (out,) of every layer of one network.
Layers = list[tuple[FloatArray, FloatArray]]
#: Fewest steps an epoch, where the data set has enough points for batches of the smallest size.
STEPS = 40
SMALLEST_BATCH = 32


def train_networks(
    inputs: FloatArray,
    outputs: FloatArray,
    held: Masks,
    widths: list[int],
    options: FeedForwardFriction,
) -> tuple[list[Layers], list[int]]:
    """Train one network for each mask of held-out points; keep its weights that are best on those points.

    The networks share nothing but the arithmetic: one batched product a layer serves all of them.

    Parameters
    ----------
    inputs, outputs : ndarray, shapes (n, widths[0]) and (n, 1)
        Standardised.
    held : list of ndarray of bool, shape (n,)
        Points that each network does not learn from. Where there is none, the last weights are kept.
    widths : list of int
        Width of every layer, input and output included.
    options : FeedForwardFriction
        Its parameters steer the training.

    Returns
    -------
    networks : list of Layers
    epochs : list of int
        Epochs until the weights that were kept.
    """
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(options.threads)
    try:
        return _train(inputs, outputs, held, widths, options)
    finally:
        torch.set_num_threads(threads)


def _train(
    inputs: FloatArray,
    outputs: FloatArray,
    held: Masks,
    widths: list[int],
    options: FeedForwardFriction,
) -> tuple[list[Layers], list[int]]:
    import torch

    rng = np.random.default_rng(options.seed)
    weights, biases = _start(rng, len(held), widths)
    tensors = [*weights, *biases]
    activation = {"tanh": torch.tanh, "relu": torch.relu, "sigmoid": torch.sigmoid}[options.activation]

    def squares(x: torch.Tensor, y: torch.Tensor) -> torch.Tensor:
        """Return squared errors, shape (networks, rows), for x of shape (networks, rows, inputs)."""
        for weight, bias in zip(weights[:-1], biases[:-1]):
            x = activation(torch.baddbmm(bias, x, weight))
        return (torch.baddbmm(biases[-1], x, weights[-1]) - y)[..., 0] ** 2

    parameters: list[dict[str, Any]] = [{"params": weights}, {"params": biases, "weight_decay": 0.0}]
    rate = options.learning_rate
    optimizer = torch.optim.AdamW(parameters, lr=rate, weight_decay=options.weight_decay, fused=True)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, options.epochs, rate * 1e-2)
    x, y = torch.from_numpy(inputs), torch.from_numpy(outputs)
    own = [np.flatnonzero(~h) for h in held]
    length = max(len(rows) for rows in own)
    batch = min(options.batch_size, max(SMALLEST_BATCH, math.ceil(length / STEPS)))
    judged, share = _padded(held)
    best, kept = np.full(len(held), math.inf), [t.detach().clone() for t in tensors]
    epochs = np.zeros(len(held), dtype=int)
    for epoch in range(1, options.epochs + 1):
        order = torch.from_numpy(np.stack([np.resize(rng.permutation(rows), length) for rows in own]))
        for rows in order.split(batch, dim=1):
            optimizer.zero_grad(set_to_none=True)
            squares(x[rows], y[rows]).mean(dim=1).sum().backward()
            optimizer.step()
        schedule.step()
        with torch.no_grad():
            errors = (squares(x[judged], y[judged]) * share).sum(dim=1).numpy()
        better = errors < best if judged.shape[1] else np.full(len(held), True)
        best[better], epochs[better] = errors[better], epoch
        chosen = torch.from_numpy(better)
        for keep, tensor in zip(kept, tensors):
            keep[chosen] = tensor.detach()[chosen]
        if epoch - epochs.max() >= options.patience:
            break
    layers = len(weights)
    arrays = [t.numpy() for t in kept]
    networks = [
        [(arrays[i][k].copy(), arrays[layers + i][k, 0].copy()) for i in range(layers)]
        for k in range(len(held))
    ]
    return networks, epochs.tolist()


def _start(
    rng: np.random.Generator, count: int, widths: list[int]
) -> tuple[list[torch.Tensor], list[torch.Tensor]]:
    """Return weights (networks, in, out), uniform as Glorot and Bengio (2010), and biases of zero."""
    import torch

    shapes = list(pairwise(widths))
    weights = [
        torch.tensor(rng.uniform(-1, 1, (count, a, b)) * math.sqrt(6 / (a + b)), requires_grad=True)
        for a, b in shapes
    ]
    biases = [torch.zeros((count, 1, b), dtype=torch.float64, requires_grad=True) for _, b in shapes]
    return weights, biases


def _padded(held: Masks) -> tuple[torch.Tensor, torch.Tensor]:
    """Return row numbers (networks, most held points), padded, and the share of each row in the mean."""
    import torch

    counts = [int(h.sum()) for h in held]
    rows = np.zeros((len(held), max(counts)), dtype=np.int64)
    share = np.zeros(rows.shape)
    for k, (mask, count) in enumerate(zip(held, counts)):
        rows[k, :count] = np.flatnonzero(mask)
        share[k, :count] = 1.0 / max(count, 1)
    return torch.from_numpy(rows), torch.from_numpy(share)
