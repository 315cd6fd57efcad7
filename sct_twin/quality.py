"""How good a record is: sampling, gaps, clipping, zeros, spikes, how far it slides."""

from __future__ import annotations

from typing import Any

import numpy as np

from friction_models.loads import FloatArray

from .record import SctRecord


def quality_row(record: SctRecord) -> dict[str, Any]:
    """Return the figures of one test as a row of the quality table (units in the names)."""
    step = np.diff(record.t)
    usual = float(np.median(step))
    unloaded = record.F_n < 0.01 * float(record.F_n.max())
    # Only what comes before the load counts as unloaded; lifting the punch is another story.
    count = int(np.argmin(unloaded)) if not unloaded.all() else 0
    zero_n = float(np.median(record.F_n[:count])) if count >= 5 else None
    zero_r = float(np.median(record.F_r[:count])) if count >= 5 else None
    return {
        "test_id": record.test_id,
        "rows": len(record),
        "duration_s": round(float(np.ptp(record.t)), 6),
        "sampling_rate_Hz": round(1.0 / usual, 3),
        "gaps": int((step > 1.5 * usual).sum()),
        "largest_gap_s": round(float(step.max()), 6),
        "F_n_max_N": round(float(record.F_n.max()), 1),
        "F_r_max_N": round(float(np.abs(record.F_r).max()), 1),
        "F_n_zero_N": None if zero_n is None else round(zero_n, 1),
        "F_r_zero_N": None if zero_r is None else round(zero_r, 1),
        "F_n_clipped": clipped(record.F_n),
        "F_r_clipped": clipped(record.F_r),
        "F_n_spikes": spikes(record.F_n),
        "F_r_spikes": spikes(record.F_r),
        "sliding_mm": round(float(np.ptp(record.s)), 4),
        "T_plate_mean_degC": round(float(record.T_plate.mean()), 2),
    }


def clipped(values: FloatArray) -> int:
    """Return how many samples sit exactly at the largest magnitude, when at least three in a row do."""
    at_limit = np.abs(values) >= np.abs(values).max()
    runs = at_limit[2:] & at_limit[1:-1] & at_limit[:-2]
    return int(at_limit.sum()) if runs.any() else 0


def spikes(values: FloatArray) -> int:
    """Return how many single samples stand out of both neighbours by ten times the usual noise."""
    bump = values[1:-1] - 0.5 * (values[2:] + values[:-2])
    noise = 1.4826 * float(np.median(np.abs(bump - np.median(bump))))
    return int((np.abs(bump) > 10.0 * noise).sum()) if noise > 0 else 0
