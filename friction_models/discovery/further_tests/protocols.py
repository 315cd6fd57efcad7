"""Tests that a rig can run: rows of a plan at freely combined settings, and the loads to expect in them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import TypeAlias

import numpy as np

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.gaps import Gap, gaps_of
from ...loads import FloatArray, TriboLoads
from ...loads.contract import QUANTITIES, SET_BY
from .heating import Heating
from .stretching import Stretching

#: One test as a row of a test plan.
PlanRow: TypeAlias = dict[str, str | float]
#: What is set in a test, by name and unit, for people.
SetPoints: TypeAlias = dict[str, float | list[float]]

POINTS = 60
#: Sliding distance that a tribometer reaches [mm].
LONGEST = 60.0
#: A rest in a test [s], and a reading without load [s].
REST, READING = 60.0, 10.0
#: A pressure ramp ends at this share of the lowest tested pressure: less force on the same contact is always possible.
RELIEVED = 0.2
#: Protocol of a constant test between the levels of a plan.
BETWEEN = "between levels"
#: Expansions that differ by more than this share are of different shapes.
OTHER_SHAPE = 0.1
#: Sliding distance of a proposed test where the data do not say how far tests slide [mm].
USUAL_DISTANCE = 20.0


@dataclass(frozen=True)
class PlannedTest:
    """One further test."""

    protocol: str  #: Name for people.
    setpoints: SetPoints  #: What is set, for people.
    #: The test as a row of a plan: ``protocol``, ``sigma_set`` [MPa], ``v_set`` [mm/s], ``T_tool`` [degC], ``sd_set`` [mm],
    #: where it is known ``psi_set``, and what the protocol needs: ``v_levels`` (text, speeds on equal parts of the distance),
    #: ``sigma_end``, ``hold_at`` [mm] and ``hold`` [s], ``zero_reading`` [s].
    row: PlanRow
    loads: TriboLoads  #: Loads to expect along it, at `POINTS` equal distances.
    #: Load of which alone it tells more than a test at usual settings: its specimen has another shape, or it lies in a gap of the load.
    about: str = ""
    fills: Gap | None = None  #: That gap.


@dataclass(frozen=True)
class Settings:
    """Levels that the tests have shown to be possible, and what a test with them looks like."""

    #: Low, middle and high [mm/s, MPa, degC].
    speed: tuple[float, float, float]
    pressure: tuple[float, float, float]
    tool: tuple[float, float, float]
    #: Specimen shapes (``psi_set``, None where it is not known) and the mean expansion that each gives; the commonest first.
    shapes: tuple[tuple[float | None, float], ...]
    distance: float  #: Usual sliding distance [mm].
    heating: Heating
    stretching: Stretching
    #: Setting in the middle of each gap that the tests leave in speed, pressure, temperature [mm/s, MPa, degC] and expansion.
    gaps: dict[Gap, float]
    unknown: tuple[str, ...] = ()  #: Columns of a plan that the data say nothing of.

    @classmethod
    def of(cls, campaign: BinnedTests) -> Settings:
        array = campaign.loads.as_array()
        low, middle, high = np.quantile(array, [0.05, 0.5, 0.95], axis=0)
        firsts = campaign.point_starts
        tool = campaign.system.get("T_tool")
        cold = array[firsts, 1] if tool is None else tool[firsts, 0]
        rise = array[:, 1] - np.repeat(cold, np.diff(np.r_[firsts, len(array)]))
        fast = max(float(high[0]), 1e-9)
        slow = max(float(low[0]), 0.01 * fast, 1e-9)
        return cls(
            (rounded(slow), rounded(float(np.sqrt(slow * fast))), rounded(fast)),
            (rounded(low[2]), rounded(middle[2]), rounded(high[2])),
            (rounded(cold.min()), rounded(np.median(cold)), rounded(cold.max())),
            _shapes(campaign, max(float(middle[4]), 1e-3)),
            _distance(campaign),
            Heating.learn(array[:, 2], array[:, 0], array[:, 3], rise),
            Stretching.learn(campaign),
            {
                gap: rounded(gap.middle - (float(np.median(rise)) if load == "T" else 0.0))
                for load in ("v_rel", "sigma_n", "T", "psi")
                for gap in gaps_of(campaign, load)
            },
            tuple(SET_BY[n] for n in campaign.absent if n in SET_BY),
        )

    def test(
        self,
        protocol: str,
        sigma: float,
        v: float,
        tool: float,
        shape: int | float = 0,
        distance: float | None = None,
        sigma_end: float | None = None,
        v_levels: tuple[float, ...] = (),
        rest_at: int | None = None,
    ) -> PlannedTest:
        """Return a test at constant settings, or with a ramp of pressure, steps of speed, or a rest before a point.

        `shape` is one of `shapes`, or an expansion that none of them gives.
        """
        length = self.distance if distance is None else distance
        row: PlanRow = {
            "protocol": "constant" if protocol in {"constant", "long run", BETWEEN} else protocol.replace(" ", "_"),
            "sigma_set": sigma, "v_set": v, "T_tool": tool, "sd_set": length,
        }  # fmt: skip
        row = {k: value for k, value in row.items() if k not in self.unknown}
        psi_set, psi = self.shapes[shape] if isinstance(shape, int) else (shape, shape)
        shown: SetPoints = {"sigma_n [MPa]": sigma, "v_rel [mm/s]": v, "T_tool [degC]": tool}
        if psi_set is not None:
            row["psi_set"] = psi_set
            if len(self.shapes) > 1:
                shown["psi_set"] = psi_set
        speed, pressure = np.full(POINTS, v), np.full(POINTS, sigma)
        if sigma_end is not None:
            row["sigma_end"], shown["sigma_n [MPa]"] = sigma_end, [sigma, sigma_end]
            pressure = sigma + (sigma_end - sigma) * np.arange(POINTS) / (POINTS - 1)
        if v_levels:
            row["v_levels"], shown["v_rel [mm/s]"] = ";".join(f"{x:g}" for x in v_levels), list(v_levels)
            speed = np.array(v_levels)[np.arange(POINTS) * len(v_levels) // POINTS]
        if rest_at is not None:
            after = rounded(length * rest_at / POINTS)
            row |= {"hold_at": after, "hold": REST}
            shown |= {"rest [s]": REST, "after [mm]": after}
        if protocol == "long run":
            shown["sd [mm]"] = length
        loads = self._loads(speed, pressure, tool, psi, length, rest_at)
        return PlannedTest(protocol, self._shown(shown), row, loads, "psi" if shape else "")

    def _shown(self, setpoints: SetPoints) -> SetPoints:
        """Return set points for people without those of loads that the data lack."""
        names = {f"{load} [": key for load, key in SET_BY.items()} | {"T_tool [": "T_tool"}
        return {
            k: value
            for k, value in setpoints.items()
            if names.get(k.partition("[")[0] + "[") not in self.unknown
        }

    def _loads(
        self, v: FloatArray, sigma: FloatArray, tool: float, psi: float, distance: float, rest_at: int | None
    ) -> TriboLoads:
        """Return the loads along a test at equal distances, with a rest before point `rest_at`."""
        sd = distance * (np.arange(POINTS) + 1.0) / POINTS
        t = np.cumsum(distance / POINTS / np.maximum(v, 1e-9))
        mean = sd / np.maximum(t, 1e-12)
        T = np.minimum(tool + self.heating.rise(sigma, mean, sd), QUANTITIES["T"].upper)
        if rest_at is not None:
            t = t + np.where(np.arange(POINTS) >= rest_at, REST, 0.0)
        return TriboLoads(v, T, sigma, sd, self.stretching.along(psi, sd), t=t)


def possible_tests(campaign: BinnedTests) -> list[PlannedTest]:
    """Return single tests within the tested range whose settings are combined freely.

    Loads that move together in the plan (fast tests that are hot ones) do not in these tests. Constant tests, also between the
    levels of the plan, speed steps, pressure ramps, holds, long runs. None where no test slides.
    """
    if not np.any(campaign.loads.v_rel > 0.0):
        return []
    s = Settings.of(campaign)
    (slow, middle, fast), (low, usual, high) = s.speed, s.pressure
    tools = sorted({s.tool[0], s.tool[2]})
    ends = sorted({low, high})
    found = [
        s.test("constant", sigma, v, tool, shape)
        for sigma, v, tool, shape in product(ends, sorted({*s.speed}), tools, range(len(s.shapes)))
    ]
    for gap, value in s.gaps.items():
        for p, v, tool in dict.fromkeys([(low, slow, tools[0]), (high, fast, tools[-1])]):
            at = {"sigma_n": p, "v_rel": v, "T": tool, "psi": 0} | {gap.load: value}
            test = s.test(BETWEEN, at["sigma_n"], at["v_rel"], at["T"], at["psi"])
            found.append(replace(test, about=gap.load, fills=gap))
    if fast > slow and "v_set" not in s.unknown:
        untested = [value for gap, value in s.gaps.items() if gap.load == "v_rel"]
        steps = [
            (slow, fast, middle, slow, fast),
            *([tuple(sorted({slow, fast, *untested}))] if untested else []),
        ]
        found += [
            s.test("speed step", p, slow, tool, v_levels=levels)
            for levels, p, tool in product(steps, ends, tools)
        ]
    relieved = rounded(RELIEVED * low)
    if high > relieved > 0.0 and "sigma_set" not in s.unknown:
        found += [
            s.test("pressure ramp", high, v, tool, sigma_end=relieved)
            for v, tool in product(sorted({*s.speed}), tools)
        ]
    if rounded(0.5 * s.distance) > 0.0:
        found += [
            s.test("hold", p, v, s.tool[1], rest_at=POINTS // 2)
            for p, v in product(ends, sorted({slow, middle}))
        ]
    longer = rounded(min(2.0 * s.distance, LONGEST))
    if longer > 1.2 * s.distance > 0.0:
        found += [
            s.test("long run", p, v, s.tool[1], distance=longer)
            for p, v in product({usual, *ends}, {middle, fast})
        ]
    return found


def _distance(campaign: BinnedTests) -> float:
    """Return how far tests usually slide: what was set, else what they reached, or the mean that averages give [mm]."""
    planned = campaign.system.get("sd_set")
    lasts = campaign.point_lasts
    reached = campaign.loads.sd if campaign.averaged else campaign.distance
    values = reached[lasts] if planned is None else planned[lasts, 0]
    distance = rounded(float(np.median(values)))
    return (
        distance if distance > 0.0 and not ("sd" in campaign.absent and planned is None) else USUAL_DISTANCE
    )


def _shapes(campaign: BinnedTests, usual: float) -> tuple[tuple[float | None, float], ...]:
    """Return the specimen shapes with the expansion that each gives, the commonest first; at most three.

    Where the test table does not say which shapes there were, the expansions that the tests reached stand for them.
    """
    column = campaign.system.get("psi_set")
    if column is None:
        if (reached := campaign.levels.get("psi")) is None:
            return ((None, usual),)
        middle, *ends = (rounded(x) for x in (np.median(reached), reached.min(), reached.max()))
        return tuple((x, x) for x in (middle, *(x for x in ends if abs(x - middle) > OTHER_SHAPE * middle)))
    values, counts = np.unique(column[campaign.point_starts, 0], return_counts=True)
    common = float(values[np.argmax(counts)])
    chosen = dict.fromkeys([common, float(values[0]), float(values[-1])])
    return tuple((x, float(np.mean(campaign.loads.psi[column[:, 0] == x]))) for x in chosen)


def rounded(value: float) -> float:
    """Return a number to three digits, as a set value."""
    return float(f"{value:.3g}")
