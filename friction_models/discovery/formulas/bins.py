"""Bin means of loads and of terms: a term over all its scan values at once, curves of products computed once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...effects.base import EffectContext
from ...effects.empirical.curves import Part, curve, factor
from ...effects.empirical.effect import Empirical
from ...effects.empirical.terms import Term
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.search.candidates import OPS, tested_ranges
from ...expressions.ops import LoadColumns
from ...loads import LOAD_NAMES, FloatArray

#: A logarithm is tried where a load goes over this ratio.
WIDE = 5.0
WAVES = ("wave", "ripple")


class Bins:
    """Bin means of the loads and of what belongs to the model.

    `columns`, shape (m, p), are the model and the named effects in the bins: free coefficients. `y`, shape (m,), is mu there
    without the fixed part of the model.
    """

    def __init__(self, campaign: BinnedTests, columns: FloatArray, y: FloatArray) -> None:
        norms = np.linalg.norm(columns, axis=0)
        columns = columns[:, norms > 0] / norms[norms > 0]
        u, s, _ = np.linalg.svd(columns, full_matrices=False)
        self.campaign, self.columns, self.y = campaign, u[:, s > 1e-7 * s[0]], y
        matrix = campaign.loads.as_array()
        self.spans = tested_ranges(campaign.loads)
        self.loads = dict(zip(LOAD_NAMES, (campaign.average(c)[:, None] for c in matrix.T), strict=True))
        #: Waves along the distance may turn within a bin.
        self._fine = dict(
            zip(LOAD_NAMES, (c[:, None] for c in campaign.pieces.loads.as_array().T), strict=True)
        )
        self._factors: dict[object, FloatArray] = {}
        self._waves: dict[Part, FloatArray] = {}

    @property
    def logarithms(self) -> tuple[str, ...]:
        """Loads that go over a wide ratio."""
        spans = {n: self.spans[f"range of {n}"] for n in ("v_rel", "sigma_n", "psi")}
        return tuple(n for n, (low, high, *_) in spans.items() if high > WIDE * low)

    def evaluate(self, effect: Empirical, shape: Mapping[str, float]) -> FloatArray:
        """Return the basis of an effect in the bins, shape (m, 1)."""
        wavy = any(map(_turns, effect.term.parts))
        loads = LoadColumns(**(self._fine if wavy else self.loads))
        values = np.asarray(effect.basis(OPS, loads, shape, EffectContext())[0])
        return self.campaign.pieces.average(values) if wavy else values

    def scan(self, term: Term) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Return a term over its scan values, (m, g), and these, (g,) each.

        Fade and trend are left out: within the tests the first is 1, and the second belongs to the model.
        """
        ranges = {n: self.spans[f"range of {n}"] for n in term.loads}
        edges = {f"lo_{n}": r[0] for n, r in ranges.items()} | {f"hi_{n}": r[1] for n, r in ranges.items()}
        grids = {n: np.asarray(v, dtype=np.float64) for n, v in term.grids(ranges).items()}
        mesh = np.meshgrid(*grids.values(), indexing="ij")
        shapes = {n: g.ravel() for n, g in zip(grids, mesh, strict=True)}
        if len(term.parts) == 1:
            rows = {n: v[None, :] for n, v in shapes.items()}
            return self._alone(term.parts[0], rows | edges), shapes
        first, second = (self._factor(part, k, grids, edges) for k, part in enumerate(term.parts, 1))
        full = np.broadcast_to(first * second, (len(self.y), *(len(g) for g in grids.values())))
        return full.reshape(len(self.y), -1), shapes

    def _alone(self, part: Part, p: Mapping[str, Any]) -> FloatArray:
        """Return a curve that is a whole term; waves are kept, they take long."""
        if part not in self._waves:
            wavy = _turns(part)
            values = np.asarray(curve(OPS, part, self._fine if wavy else self.loads, p))
            values = self.campaign.pieces.average(values) if wavy else values
            if part.form not in WAVES:
                return values
            self._waves[part] = values
        return self._waves[part]

    def _factor(
        self, part: Part, k: int, grids: Mapping[str, FloatArray], edges: Mapping[str, float]
    ) -> FloatArray:
        """Return a curve of a product, one axis for each shape parameter of the product."""
        wide = part.form not in {"line", "share", "wave"}
        own = [n for n in grids if n.endswith(f"_{k}") or (n == "w" and wide)]
        key = (part.form, part.load, tuple(len(grids[n]) for n in own))
        if key not in self._factors:
            mesh = np.meshgrid(*(grids[n] for n in own), indexing="ij") if own else []
            rows = {n: g.ravel()[None, :] for n, g in zip(own, mesh, strict=True)}
            wavy = _turns(part)
            values = np.asarray(factor(OPS, part, k, self._fine if wavy else self.loads, rows | dict(edges)))
            self._factors[key] = self.campaign.pieces.average(values) if wavy else values
        shape = [len(g) if n in own else 1 for n, g in grids.items()]
        return self._factors[key].reshape(len(self.y), *shape)


def _turns(part: Part) -> bool:
    """Return whether a curve may turn within a bin."""
    return part.form in WAVES and part.load == "sd"
