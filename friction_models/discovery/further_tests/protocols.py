"""Protocols of further tests: rows of a test plan, and the loads to expect in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ...estimation.campaign.binning import Campaign
from ...loads import FloatArray, TriboLoads
from .heating import Heating

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
#: Sliding distance of a proposed test where the data do not say how far tests slide [mm].
USUAL_DISTANCE = 20.0
#: What sets a load; a load that the data lack is left out of the proposed rows.
SET_BY = {"v_rel": "v_set", "T": "T_tool", "sigma_n": "sigma_set"}


@dataclass(frozen=True)
class Proposal:
    """Further tests.

    Attributes
    ----------
    protocol : str
        Name for people.
    setpoints : dict
        What is set, for people.
    plan : list of dict
        The tests as rows of a plan: ``protocol``, ``sigma_set`` [MPa], ``v_set`` [mm/s], ``T_tool`` [degC],
        ``sd_set`` [mm], where it is known ``psi_set``, and what the protocol needs: ``v_levels`` (text, speeds on
        equal parts of the distance), ``sigma_end``, ``hold_at`` [mm] and ``hold`` [s], ``zero_reading`` [s].
    loads : list of TriboLoads
        Loads to expect in each of them.
    """

    protocol: str
    setpoints: SetPoints
    plan: list[PlanRow]
    loads: list[TriboLoads]


@dataclass(frozen=True)
class Settings:
    """Levels within what was tested, and what a test with them looks like."""

    speed: tuple[float, float, float]
    pressure: tuple[float, float, float]
    tool: tuple[float, float, float]
    psi: float
    psi_set: float | None
    distance: float
    heating: Heating
    unknown: tuple[str, ...] = ()

    @classmethod
    def of(cls, campaign: Campaign) -> Settings:
        array = campaign.loads.as_array()
        low, middle, high = np.quantile(array, [0.05, 0.5, 0.95], axis=0)
        firsts = campaign.point_starts
        tool = campaign.system.get("T_tool")
        cold = array[firsts, 1] if tool is None else tool[firsts, 0]
        rise = array[:, 1] - np.repeat(cold, np.diff(np.r_[firsts, len(array)]))
        shapes = campaign.system.get("psi_set")
        usual = None
        if shapes is not None:
            values, counts = np.unique(shapes[firsts, 0], return_counts=True)
            usual = float(values[np.argmax(counts)])
        lasts = np.r_[firsts[1:], len(array)] - 1
        fast = max(float(high[0]), 1e-9)
        slow = max(float(low[0]), 0.01 * fast, 1e-9)
        distance = rounded(float(np.median(campaign.distance[lasts])))
        if "sd" in campaign.absent or campaign.count.size == len(campaign.tests) or not distance > 0.0:
            distance = USUAL_DISTANCE
        return cls(
            (rounded(slow), rounded(float(np.sqrt(slow * fast))), rounded(fast)),
            (rounded(low[2]), rounded(middle[2]), rounded(high[2])),
            (rounded(cold.min()), rounded(np.median(cold)), rounded(cold.max())),
            max(float(middle[4]), 1e-3),
            usual,
            distance,
            Heating.learn(array[:, 2], array[:, 0], array[:, 3], rise),
            tuple(SET_BY[n] for n in campaign.absent if n in SET_BY),
        )

    def row(self, sigma: float, v: float, tool: float, distance: float) -> PlanRow:
        row: PlanRow = {
            "protocol": "constant", "sigma_set": sigma, "v_set": v, "T_tool": tool, "sd_set": distance,
        }  # fmt: skip
        row = {k: value for k, value in row.items() if k not in self.unknown}
        return row | ({"psi_set": self.psi_set} if self.psi_set is not None else {})

    def shown(self, setpoints: SetPoints) -> SetPoints:
        """Return set points for people without those of loads that the data lack."""
        names = {f"{load} [": key for load, key in SET_BY.items()} | {"T_tool [": "T_tool"}
        return {
            k: value
            for k, value in setpoints.items()
            if names.get(k.partition("[")[0] + "[") not in self.unknown
        }

    def loads(
        self, v: FloatArray, sigma: FloatArray, tool: float, distance: float, rest_at: int | None = None
    ) -> TriboLoads:
        """Return the loads along a test at equal distances, with a rest before point `rest_at`."""
        sd = distance * (np.arange(POINTS) + 1.0) / POINTS
        t = np.cumsum(distance / POINTS / np.maximum(v, 1e-9))
        mean = sd / np.maximum(t, 1e-12)
        T = tool + self.heating.rise(sigma, mean, sd)
        if rest_at is not None:
            t = t + np.where(np.arange(POINTS) >= rest_at, REST, 0.0)
        return TriboLoads(v, T, sigma, sd, np.full(POINTS, self.psi), t=t)


def protocols(campaign: Campaign) -> list[Proposal]:
    """Return protocols within the tested range: speed step, pressure ramp, hold, long run."""
    s = Settings.of(campaign)
    (slow, middle, fast), (low, usual, high), tool = s.speed, s.pressure, s.tool[1]
    levels = (slow, fast, middle, slow, fast)
    part = np.minimum(np.arange(POINTS) * len(levels) // POINTS, len(levels) - 1)
    flat, even = np.full(POINTS, middle), np.full(POINTS, usual)
    distance = s.distance
    found = [
        Proposal(
            "speed step",
            s.shown({"v_rel [mm/s]": list(levels), "sigma_n [MPa]": usual}),
            [
                {
                    **s.row(usual, slow, tool, distance),
                    "protocol": "speed_step",
                    "v_levels": ";".join(f"{v:g}" for v in levels),
                }
            ],
            [s.loads(np.array(levels)[part], even, tool, distance)],
        )
    ]
    low = rounded(RELIEVED * low)
    if high > low > 0.0:
        ramp = high + (low - high) * np.arange(POINTS) / (POINTS - 1)
        found.append(
            Proposal(
                "pressure ramp",
                s.shown({"sigma_n [MPa]": [high, low], "v_rel [mm/s]": middle}),
                [{**s.row(high, middle, tool, distance), "protocol": "pressure_ramp", "sigma_end": low}],
                [s.loads(flat, ramp, tool, distance)],
            )
        )
    half = rounded(0.5 * distance)
    if half > 0.0:
        found.append(
            Proposal(
                "hold",
                s.shown({"v_rel [mm/s]": middle, "rest [s]": REST, "after [mm]": half}),
                [{**s.row(usual, middle, tool, distance), "protocol": "hold", "hold_at": half, "hold": REST}],
                [s.loads(flat, even, tool, distance, POINTS // 2)],
            )
        )
    longer = rounded(min(2.0 * distance, LONGEST))
    if longer > 1.2 * distance > 0.0:
        found.append(
            Proposal(
                "long run",
                s.shown({"sd [mm]": longer, "v_rel [mm/s]": middle}),
                [s.row(usual, middle, tool, longer)],
                [s.loads(flat, even, tool, longer)],
            )
        )
    return found


def rounded(value: float) -> float:
    """Return a number to three digits, as a set value."""
    return float(f"{value:.3g}")
