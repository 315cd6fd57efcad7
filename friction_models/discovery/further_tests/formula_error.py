"""How much of a lead in evidence may be a matter of formulas rather than of mechanisms.

Evidence is twice the logarithm of a likelihood. Where it is large, a rival stays as long as the lead over it is a small share of
it (`SAME`), however many standard errors of the noise that is.
"""

from __future__ import annotations

import numpy as np

from ...estimation.search.significance import SAME
from ...loads import FloatArray

#: Standard errors that are enough: rivals that are further apart leave the confusion set.
ENOUGH = 3.0


def allowance(largest: float) -> float:
    """Return by how much less a lead counts than the logarithm of the likelihood says, where `largest` is the largest evidence.

    So much less that a lead that may be a matter of formulas counts as `ENOUGH` standard errors.

    Examples
    --------
    >>> allowance(200.0), round(allowance(4500.0), 6)
    (1.0, 10.0)
    """
    return max(1.0, SAME * largest / ENOUGH**2)


def owed(evidence: FloatArray, allowed: float) -> FloatArray:
    """Return how much of a further lead of each hypothesis over each other one only makes up for wrong formulas, shape (h, h).

    `evidence`, shape (h,), is that of each hypothesis; `allowed` is the `allowance`. A lead that is there already counts.

    Examples
    --------
    Of 4500 a lead of 90 may be a matter of formulas, where 9 are three standard errors. A lead of 50 is there:

    >>> owed(np.array([4500.0, 4450.0]), 10.0).round(6).tolist()
    [[81.0, 31.0], [81.0, 81.0]]
    """
    most = SAME * max(float(evidence.max()), 0.0) * (1.0 - 1.0 / allowed)
    return np.clip(most - (evidence[:, None] - evidence), 0.0, most)
