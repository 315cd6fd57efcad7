"""Signs of a law as a whole: an effect that must rise with a load may not stand in for a law that falls with it.

Beside a base with slopes of its own, a term with the physical sign can imitate the opposite: a rising threshold in T minus
a steep line is a falling curve.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...effects.base import Effect
from ...loads import LOAD_NAMES, FloatArray
from ..campaign.binned_tests import BinnedTests
from ..noise.noise_floor import Whitener
from .scan import Prepared, drops

#: Least share of all ups and downs of the law along the load that must run the way of the effect.
OWN_WAY = 0.15
#: A term of one load that changes mu by so many times what it changes together with the base, which goes its way for less than such a
#: share of all ups and downs, is the curve of another law; limits for a name that is the answer, and for one of several. Of some 200
#: names of two authors that were right none lies within the limits (the nearest of those that were the answer went their way for 72 %);
#: of 15 curves that no effect has, humps, valleys, flat and then rising, that were given a name of one load, 14 do.
ANSWER, ONE_OF_SEVERAL = ((1.0, OWN_WAY), (1.4, 0.7)), ((1.0, OWN_WAY), (2.5, 0.5))
#: The same for the only name where the law turns along a load, whatever bends compare with it: of 27 such answers to campaigns of another
#: author (with 60 humps, valleys and parabolas over one load among 400) two were right. Along the distance, seven of nine were.
TURNED = ((0.0, 0.7), (2.0, 0.8))
#: The same for a law that is told to turn.
TOLD = ((0.0, 0.85),)
#: Ranges of the load over which ups and downs are counted.
RANGES = 25


def largest_amplitudes(campaign: BinnedTests, columns: FloatArray) -> FloatArray:
    """Return the amplitudes with which terms in the bins, shape (m, ...), change mu by as much as was measured at most, shape (...).

    What changes it by more is a difference of two large numbers, of which the base has the other one: no friction that was ever seen.
    """
    return np.asarray(campaign.largest_mu / np.maximum(np.ptp(columns, axis=0), 1e-300))


def physical_sets(
    campaign: BinnedTests,
    prepared: Prepared,
    residual: FloatArray,
    whiten: Whitener,
    columns: FloatArray,
    y: FloatArray,
) -> npt.NDArray[np.bool_]:
    """Return for each set of shape parameters whether base and effect together run the physical way somewhere.

    No term may change mu by more than was measured. Beyond that, only effects of one load, with one amplitude of known sign, are
    judged; all others are allowed. `residual`, shape (m,), is
    whitened, without the base; `columns`, shape (m, p), and `y`, shape (m,), are the base and mu in the bins.
    """
    effect, bins = prepared.candidate.effect, prepared.candidate.columns
    amplitudes = drops(prepared, np.einsum("mga,m->ga", prepared.columns, residual))[1]
    sized = np.all(np.abs(amplitudes) <= largest_amplitudes(campaign, bins), axis=1)
    name = effect.driver[0]
    signed = len(effect.driver) == 1 and len(effect.amplitudes) == 1 and effect.amplitudes[0].sign != 0
    if not signed or name not in LOAD_NAMES or not campaign.varies(name) or columns.shape[1] < 2:
        return sized
    amplitude = amplitudes[:, 0]
    # slope of the base along this load, the others held, for every set
    slopes = _slopes(campaign, name, columns)
    along = slopes @ np.linalg.pinv(whiten(columns), rcond=1e-9)
    slope = along @ whiten(y) - amplitude * (along @ whiten(bins[:, :, 0]))
    place, term = _by_range(campaign, name, bins[:, :, 0])
    term = term * amplitude
    right, ways = _ways(slope * place[:, None] + term, term)
    return np.asarray(sized & ((right >= OWN_WAY * ways) | (amplitude == 0.0)))


def imitates(campaign: BinnedTests, effect: Effect, base: FloatArray, term: FloatArray, sure: bool) -> bool:
    """Return whether an effect of one load draws another law along it, by cancelling slopes of the base.

    Its `term`, in the bins as `base` is, shape (m,), changes mu by more than both together, and these go the other way: for a good
    part where the answer is `sure` of its name, for most where it is one of several.
    """
    name, *others = effect.driver
    if others or effect.kind == "fault" or not campaign.varies(name):
        return False
    return _within(ANSWER if sure else ONE_OF_SEVERAL, *_along(campaign, name, base, term))


def turns(campaign: BinnedTests, effect: Effect, base: FloatArray, term: FloatArray) -> bool:
    """Return whether base and term together turn along the only load of an effect, a hump or a valley; both in the bins, shape (m,)."""
    name, *others = effect.driver
    if others or name == "sd" or effect.needs_state or not campaign.varies(name):
        return False
    return _within(TURNED, *_along(campaign, name, base, term))


def _within(limits: Sequence[tuple[float, float]], whole: FloatArray, own: FloatArray) -> bool:
    """Return whether a term changes mu by so many times what the whole law does, and that goes the way of the term for less than such a share."""
    right, ways = _ways(whole, own)
    cancelled = np.ptp(own) / max(float(np.ptp(whole)), 1e-300)
    return any(cancelled > times and right < share * ways for times, share in limits)


def turning_point(campaign: BinnedTests, name: str, base: FloatArray, term: FloatArray) -> float | None:
    """Return the value of a load at which base and term together turn; None where they go one way. Both in the bins, shape (m,)."""
    whole, own = _along(campaign, name, base, term)
    turn = int(np.argmin(whole) if own[-1] < own[0] else np.argmax(whole))
    if not _within(TOLD, whole, own) or turn in (0, len(whole) - 1):
        return None
    values = campaign.average(getattr(campaign.loads, name))
    return float(_by_range(campaign, name, values[:, None])[1][turn, 0])


def runs_against(campaign: BinnedTests, name: str, base: FloatArray, term: FloatArray) -> bool:
    """Return whether base and term together run the other way along a load than the term alone. Both in the bins, shape (m,)."""
    right, ways = _ways(*_along(campaign, name, base, term))
    return bool(right < 0.5 * ways)


def _along(
    campaign: BinnedTests, name: str, base: FloatArray, term: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return base and term together, and the term alone, in the ranges of a load."""
    place, columns = _by_range(campaign, name, term[:, None])
    own = columns[:, 0]
    return _slopes(campaign, name, base) * place + own, own


def _ways(whole: FloatArray, term: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ups and downs of a law that run the way of a term of it, and all of them; both along the first axis."""
    steps = np.diff(whole, axis=0) * np.sign(term[-1] - term[0])
    return np.maximum(steps, 0.0).sum(axis=0), np.abs(steps).sum(axis=0)


def _slopes(campaign: BinnedTests, name: str, columns: FloatArray) -> FloatArray:
    """Return the slope of columns by one standard deviation of a load, the other loads held, shape (...)."""
    varied = [n for n in LOAD_NAMES if campaign.varies(n)]
    straight = np.column_stack([np.ones(len(columns)), *(_scaled(campaign, n) for n in varied)])
    return np.asarray(np.linalg.lstsq(straight, columns, rcond=1e-9)[0][1 + varied.index(name)])


def _by_range(campaign: BinnedTests, name: str, columns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the means of a load, in standard deviations, and of columns, shape (m, k), in its ranges."""
    x = _scaled(campaign, name)
    order = np.argsort(x, kind="stable")
    starts = np.unique(np.linspace(0, len(x), RANGES + 1).astype(int)[:-1])
    count = np.diff(np.r_[starts, len(x)])
    return (
        np.add.reduceat(x[order], starts) / count,
        np.add.reduceat(columns[order], starts, axis=0) / count[:, None],
    )


def _scaled(campaign: BinnedTests, name: str) -> FloatArray:
    values = campaign.average(getattr(campaign.loads, name))
    return np.asarray((values - values.mean()) / max(float(values.std()), 1e-300))
