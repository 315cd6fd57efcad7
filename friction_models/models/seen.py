"""Which tests a model has seen in training. Its errors on these say little about new tests."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..loads import FloatArray

#: Significant digits of mu that count: a CSV file may change the last ones.
DIGITS = 9


def test_digests(tests: npt.ArrayLike, mu: FloatArray) -> dict[str, str]:
    """Return a short hash of the measured mu of each test, whatever the order of its points.

    Examples
    --------
    The order of the points does not matter:

    >>> one = test_digests(["a", "a", "b"], np.array([0.08, 0.07, 0.06]))
    >>> one == test_digests(["b", "a", "a"], np.array([0.06, 0.07, 0.08]))
    True
    """
    names, test = np.unique(np.asarray(tests).astype(str), return_inverse=True)
    found = {}
    for k, name in enumerate(names.tolist()):
        values = ",".join(f"{x:.{DIGITS}g}" for x in np.sort(mu[test == k]).tolist())
        found[name] = hashlib.sha256(values.encode()).hexdigest()[:12]
    return found


@dataclass(frozen=True)
class Seen:
    """Tests that a model is judged by and was trained on.

    Attributes
    ----------
    tests : list of str
    judged : int
        Number of all tests that it is judged by.
    checked : bool
        Whether the values agree, too; cards of earlier versions hold the names only.

    Examples
    --------
    >>> Seen(["a", "b"], judged=5, checked=True).sentence("linear")
    'linear was trained on 2 of the 5 tests that it is judged by: errors there say little about new tests'
    """

    tests: list[str]
    judged: int
    checked: bool

    def sentence(self, model: str) -> str:
        """Return what to know about the errors of the model."""
        count = len(self.tests)
        how_many = f"{'all' if count == self.judged else f'{count} of the'} {self.judged} tests"
        what = how_many if self.checked else f"tests with the names of {how_many}"
        return f"{model} was trained on {what} that it is judged by: errors there say little about new tests"


def seen_in_training(model: Any, tests: npt.ArrayLike, mu: FloatArray) -> Seen | None:
    """Return which of these tests a model was trained on, as its card says; None where it names none of them.

    Parameters
    ----------
    model : object
        Its ``card`` is asked, where it has one.
    tests : array_like of str, shape (n,)
        Test of each point.
    mu : ndarray, shape (n,)
        Measured, as it stands in the data.
    """
    card = getattr(model, "card", None)
    splits = card.get("splits") if isinstance(card, Mapping) else None
    trained = splits.get("train") if isinstance(splits, Mapping) else None
    if not isinstance(splits, Mapping) or not isinstance(trained, list):
        return None
    digests = test_digests(tests, mu)
    known = splits.get("digests")
    checked = isinstance(known, Mapping)
    names = {str(t) for t in trained} & set(digests)
    if isinstance(known, Mapping):
        names = {t for t in names if known.get(t) == digests[t]}
    return Seen(sorted(names), len(digests), checked) if names else None
