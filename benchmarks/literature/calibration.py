"""Reliability of the confidence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Bin:
    """Answers of similar confidence.

    Attributes
    ----------
    low, high : float
        Bounds of the confidence.
    n : int
        Number of answers.
    said, was : float
        Mean confidence and share of right answers; NaN if empty.
    """

    low: float
    high: float
    n: int
    said: float
    was: float


def reliability(confidence: list[float], right: list[bool], n_bins: int = 10) -> tuple[float, list[Bin]]:
    """Expected calibration error and reliability table.

    Parameters
    ----------
    confidence : list of float
        Confidences from 0 to 1.
    right : list of bool
        Whether each answer was right.
    n_bins : int
        Number of bins of equal width.

    Returns
    -------
    error : float
        Mean of ``|said - was|`` weighted by the number of answers (NaN without answers).
    table : list of Bin
        One entry a bin.

    References
    ----------
    Guo et al., On calibration of modern neural networks, 2017.
    """
    said, was = np.clip(np.asarray(confidence, float), 0.0, 1.0), np.asarray(right, float)
    place = np.minimum((said * n_bins).astype(int), n_bins - 1)
    table, error = [], 0.0
    for i in range(n_bins):
        here = place == i
        n = int(here.sum())
        mean, share = (
            (float(said[here].mean()), float(was[here].mean())) if n else (float("nan"), float("nan"))
        )
        table.append(Bin(i / n_bins, (i + 1) / n_bins, n, mean, share))
        error += n * abs(mean - share) if n else 0.0
    return (error / len(said) if len(said) else float("nan")), table


def by_counting(confidence: list[float], n_bins: int = 10, draws: int = 400) -> float:
    """Return the calibration error that as many answers have on average if each is right just as often as it says.

    Few answers in a bin miss their mean by chance; no confidence comes below that.
    """
    rng = np.random.default_rng(0)
    said = np.asarray(confidence, float)
    drawn = [reliability(confidence, list(rng.random(len(said)) < said), n_bins)[0] for _ in range(draws)]
    return float(np.mean(drawn))
