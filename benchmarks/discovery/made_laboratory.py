"""A made-up laboratory that runs any row of a plan under one hidden law, in forms outside the catalogue."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from .form_sets import SETS
from .forms import Array, Test
from .generator import DRIFT, DRIFT_LENGTH, SCATTER, sensor

#: Largest rms of the hidden part in the first plan, in mu.
LARGEST = 0.02
#: Points of a test lie this far apart [mm].
SPACING = 0.75


class MadeLaboratory:
    """One lubricant on one rig.

    Parameters
    ----------
    hidden : str
        An effect of the set of forms.
    forms : str
        One of `SETS`.
    seed : int
    rows : sequence of mapping
        The first plan: the hidden part is scaled to it.
    noise : float
        Factor on scatter, drift and noise of the sensor.
    strength : float
        RMS of what a linear law of the loads leaves of the hidden part in the first plan, over the scatter between tests.
    """

    def __init__(
        self,
        hidden: str,
        forms: str,
        seed: int,
        rows: Sequence[Mapping[str, Any]],
        noise: float = 1.0,
        strength: float = 1.0,
    ) -> None:
        self.hidden, self.forms, self.noise = hidden, SETS[forms], noise
        self.rng = np.random.default_rng([seed, 27, 1828])
        self.slopes = self.rng.uniform(0.4, 1.4, 5) * [1.2e-5, -3e-5, -7e-6, 9e-5, 0.007]
        self.bias = self.rng.normal(0.0, [0.012, 0.02, 0.02])  # of the twin: pressure, heating, expansion
        self.count = 0
        probe = [self._test(row, quiet=True) for row in rows]
        values = np.concatenate([self.forms.effects[hidden](r) for r in probe])
        loads = np.concatenate([np.column_stack([np.ones(len(r.v)), *_loads(r)]) for r in probe])
        loads = loads / np.maximum(np.abs(loads).max(axis=0), 1e-12)
        left = values - loads @ np.linalg.lstsq(loads, values, rcond=1e-9)[0]
        # an effect that the plan shows as a straight line only, or not at all, is not made arbitrarily large
        wanted = strength * SCATTER * noise / max(float(np.std(left)), 1e-9)
        self.size = min(wanted, LARGEST / max(float(np.std(values)), 0.05))
        self.middle = float(values.mean())
        self.count = 0

    def run(self, rows: Sequence[Mapping[str, Any]]) -> tuple[pd.DataFrame, pd.DataFrame]:
        """Return points and tests of rows of a plan, each with a specimen of its own."""
        frames, tests = [], []
        for row in rows:
            r = self._test(row)
            part = self.size * (self.forms.effects[self.hidden](r) - self.middle)
            loads = np.column_stack(_loads(r)) - [0.0, 0.0, 1500.0, 0.0, 1.0]
            mu = 0.09 + loads @ self.slopes + part + self._noise(r)
            own = self.bias + self.rng.normal(0.0, [0.006, 0.01, 0.01])
            name = f"m{self.count:03d}"
            seen = {
                "test_id": name, "t": r.t, "v_rel": r.v, "T": r.T_tool + (r.T - r.T_tool) * (1.0 + own[1]),
                "sigma_n": r.sigma * (1.0 + own[0]), "sd": r.sd, "psi": 1.0 + (r.psi - 1.0) * (1.0 + own[2]),
                "mu": np.maximum(mu, 0.002),
            }  # fmt: skip
            frames.append(pd.DataFrame(seen))
            known = {
                "order": r.order,
                "T_tool": r.T_tool,
                "Ra": r.Ra,
                "batch": r.batch,
                "psi_set": row["psi_set"],
            }
            tests.append({"test_id": name, **known})
        return pd.concat(frames, ignore_index=True), pd.DataFrame(tests)

    def _test(self, row: Mapping[str, Any], quiet: bool = False) -> Test:
        rng = np.random.default_rng(0) if quiet else self.rng
        self.count += 1
        length = float(row["sd_set"])
        sd = np.arange(0.5 * SPACING, length, SPACING)
        share = sd / length
        v_set, sigma, T_tool = float(row["v_set"]), float(row["sigma_set"]), float(row["T_tool"])
        speed = np.full(len(sd), v_set)
        if row.get("protocol") == "speed_step":
            levels = np.array([float(x) for x in str(row["v_levels"]).split(";")])
            speed = levels[np.minimum((share * len(levels)).astype(int), len(levels) - 1)]
        start = rng.uniform(0.2, 3.0) * (0.2 + v_set / 400.0)
        v = speed * (1.0 - np.exp(-(sd + 0.05) / start)) * (1.0 + 0.01 * np.sin(sd / rng.uniform(4.0, 9.0)))
        t = np.cumsum(SPACING / v)
        if row.get("protocol") == "hold":
            t = t + np.where(sd > float(row["hold_at"]), float(row["hold"]), 0.0)
        end = float(row["sigma_end"]) if row.get("protocol") == "pressure_ramp" else sigma
        pressure = (sigma + (end - sigma) * share) * (1.0 + rng.normal(0.0, 0.01))
        mean = sd / np.cumsum(SPACING / v)
        psi = float(row["psi_set"]) + rng.uniform(0.0, 0.04) * share
        T = T_tool + 18.0 * (psi - 1.0) * sigma / 1700.0 + self.forms.heating(pressure, mean, sd)
        Ra, batch = float(rng.choice([0.02, 0.06, 0.12, 0.25])), str(rng.choice(self.forms.batches))
        return Test(v, T, pressure, sd, psi, t, T_tool, float(self.count), Ra, batch)

    def _noise(self, r: Test) -> Array:
        n = len(r.sd)
        keep = float(np.exp(-SPACING / DRIFT_LENGTH))
        kicks = DRIFT * np.sqrt(1.0 - keep**2) * self.rng.standard_normal(n)
        kicks[0] = DRIFT * self.rng.standard_normal()
        wander = np.empty(n)
        wander[0] = kicks[0]
        for k in range(1, n):
            wander[k] = keep * wander[k - 1] + kicks[k]
        offset = SCATTER * self.rng.standard_normal()
        points = sensor(float(r.v[-1])) * self.rng.standard_normal(n)
        return np.asarray(self.noise * (offset + wander + points))


def _loads(r: Test) -> list[Array]:
    return [r.v, r.T, r.sigma, r.sd, r.psi]
