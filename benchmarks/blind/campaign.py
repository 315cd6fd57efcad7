"""What a campaign holds: points and tests as tables, and helpers to walk along the tests."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pandas as pd

Array = npt.NDArray[np.float64]
Rng = np.random.Generator
LOADS = ["v_rel", "T", "sigma_n", "sd", "psi"]


def generator(*words: object) -> Rng:
    """Random numbers that depend on these words only, on every machine."""
    return np.random.default_rng(zlib.crc32("|".join(map(str, words)).encode()))


@dataclass
class Campaign:
    """Points (`k` is the number of the test) and the table of tests, both without `mu`."""

    points: pd.DataFrame
    tests: pd.DataFrame

    def load(self, name: str) -> Array:
        """One column of the points."""
        return self.points[name].to_numpy(float)

    @property
    def k(self) -> npt.NDArray[np.int64]:
        """Number of the test of each point."""
        return self.points["k"].to_numpy(np.int64)

    def of_test(self, name: str) -> npt.NDArray[np.object_]:
        """One column of the test table, spread over the points."""
        return self.tests[name].to_numpy(object)[self.k]

    def number_of_test(self, name: str) -> Array:
        """One numeric column of the test table, spread over the points."""
        return self.tests[name].to_numpy(float)[self.k]

    def slices(self) -> list[slice]:
        """The rows of each test."""
        edges = np.searchsorted(self.k, np.arange(len(self.tests) + 1))
        return [slice(int(a), int(b)) for a, b in pairwise(edges)]

    def table(self, mu: Array) -> pd.DataFrame:
        """The table of points that a laboratory hands over."""
        out = self.points[["test_id", "t", *LOADS]].copy()
        out["mu"] = mu
        return out


@dataclass(frozen=True)
class Bins:
    """Averages over stretches of distance within each test: the level at which the oracle works."""

    code: npt.NDArray[np.int64]
    count: Array
    test: npt.NDArray[np.int64]

    def mean(self, values: Array) -> Array:
        """Means of a column, or of each column of a matrix, over the bins."""
        flat = values.reshape(len(values), -1)
        sums = (
            np.stack([np.bincount(self.code, c, len(self.count)) for c in flat.T], axis=1)
            / self.count[:, None]
        )
        return sums.reshape((len(self.count), *values.shape[1:]))


def bins_of(
    campaign: Campaign, edges: tuple[float, ...] = (0.5, 1.5, 3, 6, 10, 15, 20, 27, 34, 42, 50)
) -> Bins:
    """Twelve stretches a test, short where it starts."""
    raw = campaign.k * 100 + np.searchsorted(edges, campaign.load("sd"))
    labels, code, count = np.unique(raw, return_inverse=True, return_counts=True)
    return Bins(code.astype(np.int64), count.astype(float), labels // 100)
