"""Error budget on unseen tests: what the named effects explain, what is predictable beyond them, and what is not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.special import stdtr, stdtrit

from ...estimation.search.importance import LEAST_SHARE
from ...loads import FloatArray
from .unseen_tests import ErrorsByTest

#: Standard errors over the tests by which the reference must predict better than the model where nothing is named.
BELIEVED = 2.3
#: With fewer tests nothing can be said about what sets tests apart.
LEAST_TESTS = 8
#: Standard errors are counted as those of so many tests, where there are fewer.
USUAL = 27
#: Less than this share of a squared error is rounding.
ROUNDING = 1e-9


@dataclass(frozen=True)
class ErrorShares:
    """Mean squared errors of mu on unseen tests, every test with the same weight."""

    base: float  #: Of the model as it is, refitted to the other tests.
    named: float  #: Of the model with the effects that are named; the same as `base` where none is.
    best: float  #: Of the best prediction that is likely, model or reference, between and within tests each.
    certainty: float  #: Standard errors by which the reference is better than the model with what is named.
    interval: tuple[float, float]  #: 95 % interval of `best` over the tests.
    #: Whose prediction `best` is, between or within tests: of the model, the flexible reference, of terms beside what is named, or of
    #: a law that the tests of one level have.
    source: Literal["model", "reference", "terms", "level"]
    #: Standard errors by which the reference is better than the model with what is named, between or within tests, however
    #: little it is; 0 where it is not better.
    beyond: float = 0.0

    @property
    def explained(self) -> float:
        """What the named effects take from the mean squared error."""
        return max(self.base - self.named, 0.0)

    @property
    def missing(self) -> float:
        """What can be predicted and is not."""
        more = self.named - self.best
        return more if more > ROUNDING * self.named else 0.0

    @property
    def believed(self) -> bool:
        """Whether something is missing for certain."""
        return self.missing > 0.0 and self.certainty > BELIEVED

    @property
    def left(self) -> float:
        """Share of what can be predicted that is still missing."""
        return self.missing / max(self.explained + self.missing, 1e-300)


def lead(
    worse: FloatArray, better: FloatArray, setting: npt.NDArray[np.intp] | None = None
) -> tuple[float, float]:
    """Return by how much one error is smaller than another on average over tests, and by how many standard errors.

    Tests at one setting err alike, so the standard error is that of clusters (Liang, Zeger, Biometrika 73 (1986) 13). Of few tests it
    is hardly known itself: there it is as many standard errors as are as rare with `USUAL` ones (Student's t).

    Examples
    --------
    >>> [round(x, 2) for x in lead(np.array([3.0, 5.0, 4.0]), np.array([1.0, 1.0, 1.0]))]
    [3.0, 2.22]
    >>> [round(x, 2) for x in lead(np.array([3.0, 3.0, 5.0, 5.0]), np.ones(4), np.array([0, 0, 1, 1]))]
    [3.0, 1.3]
    """
    difference = worse - better
    tests, mean = len(difference), float(np.mean(difference))
    of_settings = np.bincount(np.arange(tests) if setting is None else setting, difference - mean)
    count = len(of_settings)
    spread = np.sqrt(count / (count - 1) * np.sum(of_settings**2)) / tests if count > 1 else np.inf
    certain = float(mean / max(float(spread), 1e-300))
    if 1 < count < USUAL:
        as_rare = abs(float(stdtrit(USUAL - 1, stdtr(count - 1, -abs(certain)))))
        certain = float(np.copysign(min(as_rare, abs(certain)), certain))
    return mean, certain


def fall(before: ErrorsByTest, after: ErrorsByTest, part: str = "total") -> tuple[float, float]:
    """Return the `lead` of the second errors in total, `between` or `within` tests."""
    return lead(getattr(before, part), getattr(after, part), before.setting)


def helps(before: ErrorsByTest, after: ErrorsByTest, needed: float = 1.0) -> bool:
    """Return whether an addition lowers the error on unseen tests, in all (by `needed` standard errors) or along them."""
    gain, certain = fall(before, after)
    if gain > LEAST_SHARE * before.rms**2 and certain > needed:
        return True
    along, sure = fall(before, after, "within")
    return bool(sure > 2.5 and along > LEAST_SHARE * before.rms**2 and gain > 0.0)


def likely(certain: float) -> float:
    """Return the share of a gain, so many standard errors large, that is likely to be there.

    Positive part of the estimate of James and Stein (Efron, Morris, J. Am. Stat. Assoc. 68 (1973) 117): a gain that counts in
    full from some level on, and not at all below it, would be a matter of single tests.

    Examples
    --------
    >>> likely(0.5), likely(2.0), likely(10.0)
    (0.0, 0.75, 0.99)
    """
    return max(0.0, 1.0 - 1.0 / max(certain, 1e-9) ** 2)


def error_shares(
    base: ErrorsByTest,
    named: ErrorsByTest,
    known: Sequence[ErrorsByTest],
    weighed: ErrorsByTest,
    needed: float = 1.0,
) -> ErrorShares:
    """Return the error budget of a model as it is, and with the effects that are named, beside other predictions of the same tests.

    What these predict better counts from so many standard errors on as `needed`: that something is missing at all has to be sure.
    The model with the effects may predict better, too, where tests and points are `weighed` by their noise: that is no structure.
    One that errs in a test by more than the model does in any knows nothing of it, by however much: curves end where other tests
    do, and a single test beyond them would else hide what is known of all others.
    """
    tests = len(named.total)
    best, certainty, beyond = np.zeros(tests), 0.0, 0.0
    for part in ("between", "within"):
        least = own = getattr(named, part)
        if (better := getattr(weighed, part)).mean() < own.mean():
            own = better
        if part == "within" or tests >= LEAST_TESTS:
            for other in (np.minimum(getattr(k, part), own.max()) for k in known):
                gain, certain = lead(own, other, named.setting)
                beyond = max(beyond, certain)
                nearer = own + likely(certain) * (other - own)
                if certain > needed and gain > LEAST_SHARE * base.rms**2 and nearer.mean() < least.mean():
                    least, certainty = nearer, max(certainty, certain)
        best = best + least
    return ErrorShares(
        base.rms**2,
        named.rms**2,
        float(np.mean(best)),
        certainty,
        interval_of(best),
        "reference" if certainty > 0.0 else "model",
        beyond,
    )


def interval_of(squares: FloatArray) -> tuple[float, float]:
    """Return the 95 % interval of a mean of squares over tests, on the scale of their logarithm."""
    tests, mean = len(squares), float(np.mean(squares))
    error = float(np.std(squares, ddof=1)) / np.sqrt(tests) / max(mean, 1e-300)
    factor = float(np.exp(stdtrit(tests - 1, 0.975) * error))
    return mean / factor, mean * factor
