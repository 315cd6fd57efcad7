"""A broad prior of friction laws, plans and noises, by which the confidence of the diagnosis is calibrated.

Nothing here is taken from the catalogue or from another benchmark: shapes are drawn at random, only their direction and the load
that they follow are given. ``python -m benchmarks.prior -o FOLDER`` draws campaigns, diagnoses them, and fits the confidence.
"""

from __future__ import annotations

from .study import measure

__all__ = ["measure"]
