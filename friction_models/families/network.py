"""Training of many small fully connected networks at once with torch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..common import InputError
from ..loads import FloatArray

if TYPE_CHECKING:
    import torch

Masks = list[npt.NDArray[np.bool_]]
#: Weights (in, out) and biases (out,) of every layer of one network.
Layers = list[tuple[FloatArray, FloatArray]]
#: Networks of one model, and the epochs until the weights that were kept.
Trained = tuple[list[Layers], list[int]]
#: Fewest steps an epoch, where the data set has enough points for batches of the smallest size.
STEPS = 40
SMALLEST_BATCH = 32


@dataclass(frozen=True)
class TrainingOptions:
    """What networks that are trained in one batch share; see `FeedForwardFriction`."""

    widths: tuple[int, ...]
    activation: str
    learning_rate: float
    batch_size: int
    epochs: int
    patience: int
    threads: int


@dataclass(frozen=True)
class Lesson:
    """What the networks of one model learn from."""

    #: Standardised; shapes (n, inputs) and (n, 1).
    inputs: FloatArray
    outputs: FloatArray
    #: Points that each network does not learn from. Where there is none, the last weights are kept; shape
    #: (n,).
    held: Masks
    #: Of the first weights and the order of the points.
    seed: int
    weight_decay: float
    #: Of the points, mean 1; None: all weigh alike; shape (n,).
    weights: FloatArray | None = None


def train_networks(lessons: Sequence[Lesson], options: TrainingOptions) -> list[Trained]:
    """Train one network for each mask of held-out points of each lesson; keep its weights that are best on those.

    Returns for each lesson its networks, and for each network the epochs until the weights that were kept.

    The networks share nothing but the arithmetic: one batched product a layer serves all of them. Lessons of
    equal length come out, to rounding, as they do one by one; a shorter one repeats some of its points in an
    epoch, so that all take the same steps.

    Raises InputError: torch is not installed.
    """
    try:
        import torch
    except ImportError:
        raise InputError(
            "ffnn: torch, which trains networks, is not installed; allowed: pip install 'tribofmu[train-networks]' "
            "(predicting with a trained network needs no torch)"
        ) from None

    threads = torch.get_num_threads()
    torch.set_num_threads(options.threads)
    try:
        return _train(lessons, options)
    finally:
        torch.set_num_threads(threads)


def _train(lessons: Sequence[Lesson], options: TrainingOptions) -> list[Trained]:
    import torch

    widths = list(options.widths)
    generators = [np.random.default_rng(lesson.seed) for lesson in lessons]
    starts = [_start(rng, len(lesson.held), widths) for rng, lesson in zip(generators, lessons)]
    layers = len(widths) - 1
    tensors = [
        torch.from_numpy(np.concatenate(parts)).requires_grad_() for parts in zip(*starts, strict=True)
    ]
    weights, biases = tensors[:layers], tensors[layers:]
    activation = {"tanh": torch.tanh, "relu": torch.relu, "sigmoid": torch.sigmoid}[options.activation]

    def squares(x: torch.Tensor, y: torch.Tensor) -> torch.Tensor:
        """Return squared errors, shape (networks, rows), for x of shape (networks, rows, inputs)."""
        for weight, bias in zip(weights[:-1], biases[:-1]):
            x = activation(torch.baddbmm(bias, x, weight))
        return (torch.baddbmm(biases[-1], x, weights[-1]) - y)[..., 0] ** 2

    rate = options.learning_rate
    optimizer = torch.optim.Adam(tensors, lr=rate, fused=True)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, options.epochs, rate * 1e-2)
    x = torch.from_numpy(np.concatenate([lesson.inputs for lesson in lessons]))
    y = torch.from_numpy(np.concatenate([lesson.outputs for lesson in lessons]))
    counts_as = torch.from_numpy(
        np.concatenate([np.ones(len(le.inputs)) if le.weights is None else le.weights for le in lessons])
    )
    offsets = [0, *accumulate(len(lesson.inputs) for lesson in lessons)]
    own = [
        [offset + np.flatnonzero(~mask) for mask in lesson.held] for lesson, offset in zip(lessons, offsets)
    ]
    length = max(len(rows) for group in own for rows in group)
    batch = _batch(length, options.batch_size)
    judged, share = _padded([(offset, m) for lesson, offset in zip(lessons, offsets) for m in lesson.held])
    judged_x, judged_y, share = x[judged], y[judged], share * counts_as[judged]
    decay = torch.from_numpy(np.repeat([le.weight_decay for le in lessons], [len(le.held) for le in lessons]))
    counts = [len(lesson.held) for lesson in lessons]
    groups = [slice(end - count, end) for end, count in zip(accumulate(counts), counts)]
    best, kept = np.full(sum(counts), math.inf), [t.detach().clone() for t in tensors]
    epochs = np.zeros(sum(counts), dtype=int)
    learning = np.full(sum(counts), True)
    for epoch in range(1, options.epochs + 1):
        order = torch.from_numpy(
            np.stack(
                [
                    np.resize(rng.permutation(rows), length)
                    for rng, group in zip(generators, own)
                    for rows in group
                ]
            )
        )
        # Decoupled from the gradient, as in AdamW (Loshchilov and Hutter, 2019); each model has its own.
        shrink = (1.0 - optimizer.param_groups[0]["lr"] * decay)[:, None, None]
        for rows in order.split(batch, dim=1):
            optimizer.zero_grad(set_to_none=True)
            (squares(x[rows], y[rows]) * counts_as[rows]).mean(dim=1).sum().backward()
            with torch.no_grad():
                for weight in weights:
                    weight.mul_(shrink)
            optimizer.step()
        schedule.step()
        with torch.no_grad():
            errors = (squares(judged_x, judged_y) * share).sum(dim=1).numpy()
        better = (errors < best if judged.shape[1] else np.full(len(best), True)) & learning
        best[better], epochs[better] = errors[better], epoch
        chosen = torch.from_numpy(better)
        for keep, tensor in zip(kept, tensors):
            keep[chosen] = tensor.detach()[chosen]
        # A model stops when none of its networks gets better, whatever the others do.
        for group in groups:
            learning[group] &= epoch - epochs[group].max() < options.patience
        if not learning.any():
            break
    arrays = [t.numpy() for t in kept]
    networks: list[Layers] = [
        [(arrays[i][k].copy(), arrays[layers + i][k, 0].copy()) for i in range(layers)]
        for k in range(len(best))
    ]
    return [(networks[group], epochs[group].tolist()) for group in groups]


def epochs_for(steps: int, points: float, batch_size: int) -> int:
    """Return the epochs that take about so many steps with a training set of so many points."""
    return max(1, round(steps / math.ceil(max(points, 1.0) / _batch(points, batch_size))))


def _batch(points: float, batch_size: int) -> int:
    return min(batch_size, max(SMALLEST_BATCH, math.ceil(points / STEPS)))


def _start(rng: np.random.Generator, count: int, widths: list[int]) -> list[FloatArray]:
    """Return weights (networks, in, out), uniform as Glorot and Bengio (2010), then biases of zero."""
    shapes = list(pairwise(widths))
    weights: list[FloatArray] = [
        rng.uniform(-1, 1, (count, a, b)) * math.sqrt(6 / (a + b)) for a, b in shapes
    ]
    return [*weights, *(np.zeros((count, 1, b)) for _, b in shapes)]


def _padded(held: list[tuple[int, npt.NDArray[np.bool_]]]) -> tuple[torch.Tensor, torch.Tensor]:
    """Return row numbers (networks, most held points), padded, and the share of each row in the mean.

    `held` has the first row of its lesson and the mask of each network.
    """
    import torch

    counts = [int(mask.sum()) for _, mask in held]
    rows = np.zeros((len(held), max(counts)), dtype=np.int64)
    share = np.zeros(rows.shape)
    for k, ((offset, mask), count) in enumerate(zip(held, counts)):
        rows[k, :count] = offset + np.flatnonzero(mask)
        share[k, :count] = 1.0 / max(count, 1)
    return torch.from_numpy(rows), torch.from_numpy(share)
