"""Readings of the friction cell without load: do they confirm the force offset that the data suggest?

The test table holds the readings before and after a test as ``F_r_zero`` (0 where it is missing) and ``F_r_zero_end`` [N].
The reading before a test has been subtracted from its record, so an offset that begins with the load shows in the difference
of the two. Divided by the contact area (``contact_area`` [mm2]) it is a friction stress, to be compared with the amplitude of
`force_zero`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from ...common.wording import counted, first_names, listed
from ...loads import FloatArray
from ..campaign.binned_tests import BinnedTests
from ..noise.noise_floor import sensor_noise
from .candidates import Candidate
from .form_error import FORM_ERROR
from .scan import Fit
from .search_round import SearchRound

#: The effect that a reading without load tells from any other.
ZERO = "force_zero"
BEFORE, AFTER, AREA = "F_r_zero", "F_r_zero_end", "contact_area"
#: Standard errors by which a reading decides.
DECIDES = 3.0
#: Drift of the sensor over the campaign, which no reading confirms.
DRIFT = "sensor_drift"
#: Largest share of the measured mu of a test that an unread zero error, or a drift, makes. A cell is off by 1 or 2 % of full scale, which is
#: 10 to 20 % of the smallest of forces that span a decade; more would show in every unloaded record.
CREDIBLE = 0.25
#: Independent readings of a force cell in one second without load, and seconds that a reading lasts at least.
READINGS, LEAST_READING = 20.0, 1.0


@dataclass(frozen=True)
class ZeroReading:
    """Offset of the friction force by readings without load, as friction stress on the contact."""

    #: Bounds of the offset [MPa], on average over the tests. Records with a reading after the test are corrected for part of it
    #: already.
    low: float
    high: float
    #: Standard error of a reading [MPa]: noise of the cell and scatter of its zero from test to test.
    std: float
    spread: float  #: Relative error of the effect on mu, because contact areas differ.
    area: float  #: Of the contact [mm2].

    def away(self, stress: float) -> float:
        """Return how far a stress lies outside the bounds [MPa]."""
        return max(self.low - stress, stress - self.high, 0.0)

    @property
    def present(self) -> float:
        """Standard errors by which the offset differs from zero."""
        return self.away(0.0) / self.std

    def against(self, needed: float, std: float) -> float:
        """Return the standard errors by which the offset differs from the one that the data need [MPa]."""
        own = self.spread * max(abs(self.low), abs(self.high))
        return self.away(needed) / float(np.sqrt(self.std**2 + own**2 + std**2))


def cell_noise(sensor: float, sigma_n: FloatArray, seconds: float) -> float:
    """Return the standard error of a reading without load of some seconds [MPa].

    `sensor` is the noise of mu from sample to sample, `sigma_n` holds the contact pressures at which it was found [MPa].
    """
    return sensor * float(np.median(sigma_n)) / float(np.sqrt(seconds * READINGS))


def needed_offset(fit: Fit) -> tuple[float, float]:
    """Return the friction stress that a fit of `force_zero` needs, and its standard error [MPa]."""
    s_0 = fit.shape["s_0"]
    square = float(fit.prepared.gram[fit.index, 0, 0])
    return float(fit.amplitudes[0]) * s_0, s_0 / float(np.sqrt(max(square, 1e-300)))


def read_zero(campaign: BinnedTests, sensor: float) -> ZeroReading | None:
    """Return what the test table says about the zero of the friction cell; None where it says nothing.

    `sensor` is the noise of mu from sample to sample.
    """
    table = campaign.loads.context
    if table is None or AFTER not in table.columns or AREA not in table.columns:
        return None
    # of a test whose record was left out the reading holds all the same
    after, area = _numbers(table, AFTER), _numbers(table, AREA)
    before = np.nan_to_num(_numbers(table, BEFORE))
    read, known = np.isfinite(after), area[np.isfinite(area) & (area > 0.0)]
    if not read.any() or not len(known):
        return None
    typical = float(np.median(known))
    # the zero that was subtracted from most records; none where records begin under load
    usual = before[~read] if not read.all() else before
    moved = (after - float(np.mean(usual != 0.0)) * before)[read] / typical
    reading = float(np.median(moved))
    kept = reading * (1.0 - float(np.mean(read)))
    std = np.hypot(_repeats(campaign), float(np.std(moved))) / np.sqrt(len(moved))
    std = float(np.hypot(std, cell_noise(sensor, campaign.loads.sigma_n, LEAST_READING)))
    spread = float(np.hypot(FORM_ERROR, np.std(known) / typical))
    return ZeroReading(min(kept, reading), max(kept, reading), max(std, 1e-12), spread, typical)


def corrected_alone(campaign: BinnedTests) -> list[str]:
    """Return the tests whose records a reading of the offset has corrected, where the others were not read: they contradict these."""
    table = campaign.loads.context
    if table is None or AFTER not in table.columns:
        return []
    if not zero_is_known(campaign, sensor_noise(campaign, campaign.mu)):
        return []
    read = table.index[np.isfinite(_numbers(table, AFTER))]
    names = [name for name in campaign.tests if name in read]
    return names if 2 * len(names) < len(campaign.tests) else []


def corrected_text(names: list[str]) -> str:
    """Return what is said of tests that `corrected_alone` has found."""
    many = len(names) > 1
    return (
        f"the friction force of {counted(len(names), 'test')} ({first_names(names)}) was corrected by {'their' if many else 'its'} own reading without load, "
        f"that of the others was not: only the reading{'s are' if many else ' is'} used"
    )


def zero_is_known(campaign: BinnedTests, sensor: float) -> bool:
    """Return whether readings without load have decided that there is an offset; `sensor` as in `read_zero`."""
    reading = read_zero(campaign, sensor)
    return reading is not None and reading.present > DECIDES


def share_of_mu(campaign: BinnedTests, binned: FloatArray) -> float:
    """Return the largest share that a contribution in the bins, shape (m,), has in the measured mu of a test."""
    measured = np.abs(campaign.of_tests(campaign.average(campaign.mu)))
    return float(np.max(np.abs(campaign.of_tests(binned)) / np.maximum(measured, 1e-12)))


def credible(campaign: BinnedTests, sensor: float, fit: Fit) -> bool:
    """Return whether a fit may stand beside other names: an offset that was not read, or a drift, is small against what is measured.

    A larger one is structure along the pressure, or along what changed in the order of the tests. `sensor` is the noise of mu from
    sample to sample.
    """
    if fit.name not in (ZERO, DRIFT) or share_of_mu(campaign, fit.binned) <= CREDIBLE:
        return True
    return fit.name == ZERO and zero_is_known(campaign, sensor)


def expected(campaign: BinnedTests, sensor: float, fault: Fit, seconds: float) -> float:
    """Return the standard errors by which a reading without load of some seconds should decide about `force_zero`.

    The smaller value of two cases counts: the offset is as large as `fault` needs, or there is none. `sensor` is the noise of
    mu from sample to sample.
    """
    needed, error = needed_offset(fault)
    noise = float(np.hypot(cell_noise(sensor, campaign.loads.sigma_n, seconds), _repeats(campaign)))
    there, not_there = (ZeroReading(x, x, max(noise, 1e-12), FORM_ERROR, 1.0) for x in (needed, 0.0))
    return min(there.present, not_there.against(needed, error))


def _repeats(campaign: BinnedTests) -> float:
    """Return the standard deviation of the zero from test to test, as friction stress [MPa]; 0 where it is not known."""
    table = campaign.loads.context
    if table is None or BEFORE not in table.columns or AREA not in table.columns:
        return 0.0
    rows = table[table.index.isin(campaign.tests)]
    return float(np.nan_to_num(np.nanstd(_numbers(rows, BEFORE)) / np.nanmedian(_numbers(rows, AREA))))


def _numbers(rows: pd.DataFrame, name: str) -> FloatArray:
    if name not in rows.columns:
        return np.full(len(rows), np.nan)
    return pd.to_numeric(rows[name], errors="coerce").to_numpy(dtype=np.float64)


def judge_zero(
    campaign: BinnedTests, found: SearchRound, candidates: list[Candidate]
) -> tuple[list[Candidate], list[str]]:
    """Let a reading without load decide between `force_zero` and the laws of pressure.

    A reading that contradicts the offset which `force_zero` needs rules this effect out. A reading that confirms it adds to its
    evidence, and laws of pressure with clearly less evidence leave the ranking of the search. Returns the candidates that are
    still possible, and what the reading said.
    """
    fault = next((f for f in found.ranking if f.name == ZERO), None)
    reading = None if fault is None else read_zero(campaign, found.floor.sensor)
    if fault is None or reading is None:
        return candidates, []
    needed, error = needed_offset(fault)
    shown = f"the friction cell reads {reading.area * _far(reading):.0f} N without load after the load"
    if reading.against(needed, error) > DECIDES:
        found.ranking = [f for f in found.ranking if f is not fault]
        said = f"{shown}, {ZERO} would need {reading.area * needed:.0f} N: it is ruled out"
        if reading.present > DECIDES:
            said += "; take the offset off the friction force first"
        return [c for c in candidates if c.effect.name != ZERO], [said]
    if reading.present <= DECIDES:
        return candidates, []
    fault.evidence += reading.present**2

    def beaten(fit: Fit) -> bool:
        same = fit is not fault and fit.effect.driver == fault.effect.driver
        return same and fit.evidence + DECIDES**2 < fault.evidence

    out = [f.name for f in found.ranking if beaten(f) and f.gain > 0.0]
    found.ranking = sorted((f for f in found.ranking if not beaten(f)), key=lambda f: -f.evidence)
    said = f"{shown}, as {ZERO} needs ({reading.area * needed:.0f} N)"
    return candidates, [said + (f": it leaves {listed(out)} behind" if out else "")]


def _far(reading: ZeroReading) -> float:
    return max(reading.low, reading.high, key=abs)
