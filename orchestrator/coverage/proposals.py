"""Which further tests of the rig would cover the loads of a process, and what no test of it reaches."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pandas as pd

from friction_models.common import InputError, unknown_name
from friction_models.discovery.further_tests.heating import Heating
from friction_models.loads import LOAD_NAMES, LOADS, FloatArray
from friction_models.loads.contract import behind

from .tested_loads import Coverage, Region, natural_columns, regions_of

#: Contact states that take part in the choice of tests.
SAMPLE = 2000
#: Points along a proposed test.
ALONG = np.array([0.002, 0.01, 0.05, 0.15, 0.3, 0.5, 0.75, 1.0])
#: A further test must cover this share more.
WORTH = 0.005
MOST_TESTS = 5
#: Specimen shapes that are told apart.
MOST_SHAPES = 6
#: Tests of about the same speed that say how a test starts.
ALIKE = 3
#: Settings that are tried for a test.
MOST_CANDIDATES = 400


@dataclass(frozen=True)
class Rig:
    """What a tribometer can be set to: least and largest values, and shapes.

    Examples
    --------
    >>> Rig.read(["v_set=0.5:800"]).v_set
    (0.5, 800.0)
    """

    sigma_set: tuple[float, float] = (500.0, 2750.0)  # pressure [MPa]
    v_set: tuple[float, float] = (5.0, 500.0)  # speed [mm/s]
    T_tool: tuple[float, float] = (20.0, 300.0)  # tool temperature [degC]
    sd_set: tuple[float, float] = (5.0, 60.0)  # sliding distance [mm]
    psi_set: tuple[float, ...] = ()  # nominal expansions, so specimen shapes; none: those of the tests

    @classmethod
    def read(cls, texts: Iterable[str]) -> Rig:
        """Build from texts such as ``v_set=0.5:800`` or ``psi_set=1.07,5,20``."""
        values: dict[str, tuple[float, ...]] = {}
        names = ("sigma_set", "v_set", "T_tool", "sd_set", "psi_set")
        for text in texts:
            name, _, rest = (part.strip() for part in text.partition("="))
            if name not in names:
                raise unknown_name("limit of the rig", name, names)
            listed = name == "psi_set"
            try:
                numbers = tuple(float(p) for p in rest.split("," if listed else ":"))
            except ValueError:
                numbers = ()
            low = -50.0 if name == "T_tool" else 1e-6
            fits = numbers and all(low <= x <= 1e5 for x in numbers)
            if not fits or not (listed or (len(numbers) == 2 and numbers[0] < numbers[-1])):
                raise InputError(
                    f"rig {text!r}; allowed: {name}=LOW:HIGH with LOW below HIGH (psi_set=VALUE,VALUE,...)"
                )
            values[name] = numbers
        return replace(cls(), **values)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Response:
    """How the loads in the contact follow from what is set, learned from n tests."""

    shapes: FloatArray  # nominal expansions that were tested, shape (k,)
    pressure: FloatArray  # constant and slope over the set pressure for each of them, shape (k, 2)
    expansion: FloatArray  # the same
    heating: Heating  # how much warmer than the tool the contact gets
    speeds: FloatArray  # highest speed of each test, shape (n,) [mm/s]
    #: Speed along each test as a share of its highest, shape (n, len(ALONG)): how much of the start of the plate it shows.
    motions: FloatArray

    @classmethod
    def learn(cls, points: pd.DataFrame, tests: pd.DataFrame | None) -> Response:
        """Learn from points and the test table; what the table lacks is read off the points."""
        by = points.groupby("test_id", sort=False)
        found = by[["sigma_n", "psi"]].median()
        table = pd.DataFrame(
            {"sigma_set": found["sigma_n"], "psi_set": found["psi"].round(2), "T_tool": by["T"].min()}
        )
        if tests is not None:
            known = tests.set_index(tests["test_id"].astype(str))
            for name in table.columns:
                if name in known.columns:
                    values = pd.to_numeric(known[name], errors="coerce").reindex(table.index)
                    table[name] = values.fillna(table[name])
        psi_set, sigma_set = table["psi_set"].to_numpy(dtype=float), table["sigma_set"].to_numpy(dtype=float)
        shapes = np.unique(psi_set)
        if len(shapes) > MOST_SHAPES:
            shapes = np.unique(np.quantile(shapes, np.linspace(0.0, 1.0, MOST_SHAPES), method="nearest"))
        nearest = np.argmin(np.abs(np.log(psi_set[:, None] / shapes)), axis=1)
        lines = [
            [_line(sigma_set[nearest == k], found[c].to_numpy()[nearest == k]) for k in range(len(shapes))]
            for c in ("sigma_n", "psi")
        ]
        tool = table["T_tool"].reindex(points["test_id"].astype(str)).to_numpy(dtype=float)
        rise = points["T"].to_numpy(dtype=float) - tool
        sigma, v, sd = (points[n].to_numpy(dtype=float) for n in ("sigma_n", "v_rel", "sd"))
        heating = Heating.learn(sigma, v, sd, rise)
        motions = [
            _motion(test["sd"].to_numpy(dtype=float), test["v_rel"].to_numpy(dtype=float)) for _, test in by
        ]
        fastest = by["v_rel"].max().to_numpy(dtype=float)
        return cls(shapes, np.array(lines[0]), np.array(lines[1]), heating, fastest, np.array(motions))

    def loads(self, s: Mapping[str, float]) -> FloatArray:
        """Return the loads along a test with these settings, shape (k, 5)."""
        sd = ALONG * s["sd_set"]
        at = np.log(s["psi_set"])
        sigma, psi = (
            float(np.interp(at, np.log(self.shapes), table @ [1.0, s["sigma_set"]]))
            for table in (self.pressure, self.expansion)
        )
        sigma, psi = max(sigma, 1.0), max(psi, 0.05)
        # A fast test shows more of the start than a slow one.
        alike = np.argsort(np.abs(np.log(np.maximum(self.speeds, 1e-9) / s["v_set"])), kind="stable")[:ALIKE]
        v = s["v_set"] * np.median(self.motions[alike], axis=0)
        rise = self.heating.rise(np.full(len(sd), sigma), v, sd)
        return np.column_stack([v, s["T_tool"] + rise, np.full(len(sd), sigma), sd, np.full(len(sd), psi)])


def _motion(sd: FloatArray, v: FloatArray) -> FloatArray:
    """Return the speed at `ALONG` shares of the distance of a test, as a share of its highest speed."""
    order = np.argsort(sd, kind="stable")
    return np.interp(ALONG * max(float(sd.max()), 1e-9), sd[order], v[order]) / max(float(v.max()), 1e-9)


def _line(x: FloatArray, y: FloatArray) -> list[float]:
    """Return constant and slope; the mean where x hardly varies."""
    if np.ptp(x) < 0.05 * max(float(np.abs(x).max()), 1e-9):
        return [float(y.mean()), 0.0]
    slope, constant = np.polyfit(x, y, 1)
    return [float(constant), float(slope)]


def propose_tests(
    coverage: Coverage, points: pd.DataFrame, tests: pd.DataFrame | None = None, rig: Rig | None = None
) -> None:
    """Add to a coverage the tests that would cover most of what is outside, and what none would.

    Rows are those of a test plan: ``sigma_set``, ``psi_set``, ``v_set``, ``T_tool``, ``sd_set``. Tests are
    chosen one after the other, each for the largest share of contact area and friction work it adds.
    """
    rig = rig or Rig()
    history = coverage.history
    if coverage.whole.area < WORTH and coverage.whole.work < WORTH:
        return
    response = Response.learn(points, tests)
    step = max(len(history.area) // SAMPLE, 1)
    asked, area, work = history.loads[::step], history.area[::step], history.work[::step]
    area, work = area / area.sum(), work / max(float(work.sum()), 1e-300)
    candidates = _candidates(rig, response, asked, history.present)
    clouds = [response.loads(c) for c in candidates]
    tested, present = coverage.tested, history.present
    # Of all states, as the shares of the tables are: a part must not be larger than the whole.
    reached = np.vstack([tested, *clouds])
    everything = _inside(regions_of(reached, present), history.loads)
    coverage.beyond_rig = _unreachable(history.loads, everything, history.work, reached, present)
    weight = 0.5 * (area + work)
    covered = _inside(regions_of(tested, present), asked)
    for _ in range(MOST_TESTS):
        corners = _corners(regions_of(tested, present), tested)
        best, chosen, inside = 0.0, -1, covered
        for k, cloud in enumerate(clouds):
            grown = [Region.of(n, np.vstack([old, natural_columns(cloud, n)])) for n, old in corners.items()]
            now = _inside(grown, asked)
            # where nothing reaches one load, the others still count: the mean over loads and pairs
            gain = float(np.mean((now & ~covered) @ weight))
            if gain > best + 1e-9:
                best, chosen, inside = gain, k, now
        names = list(corners)
        added = _shown(names, inside, covered, weight)
        if max(added) < WORTH:
            break
        gains = sorted(zip(added, names, strict=True), reverse=True)
        coverage.proposals.append(
            {
                "setpoints": dict(candidates[chosen]),
                "plan": [{"protocol": "constant", **candidates[chosen]}],
                "covers": [{"loads": list(n), "share": g} for g, n in gains[:3] if g >= WORTH],
                "area_covered": float(inside.all(axis=0) @ area),
                "work_covered": float(inside.all(axis=0) @ work),
            }
        )
        tested = np.vstack([tested, clouds[chosen]])
        covered = covered | inside
    if not coverage.proposals:
        coverage.notes.append("no single test within the limits of the rig covers noticeably more")


def _shown(
    names: list[tuple[str, ...]], inside: np.ndarray, covered: np.ndarray, weight: FloatArray
) -> list[float]:
    """Return what a test adds by load and pair; a state counts for a pair where each load alone was covered, as in the table."""
    alone = {name[0]: covered[k] for k, name in enumerate(names) if len(name) == 1}
    added = []
    for k, name in enumerate(names):
        new = inside[k] & ~covered[k]
        for load in name if len(name) > 1 else ():
            new = new & alone[load]
        added.append(float(weight @ new))
    return added


def _candidates(
    rig: Rig, response: Response, asked: FloatArray, present: tuple[str, ...]
) -> list[dict[str, float]]:
    """Return settings within the rig: its limits, and levels where the process asks for something."""

    def levels(limits: tuple[float, float], values: FloatArray, log: bool) -> list[float]:
        held = values[np.isfinite(values)]
        inside = np.clip(np.quantile(held, [0.1, 0.5, 0.9]), *limits).tolist() if len(held) else []
        middle = float(np.sqrt(limits[0] * limits[1])) if log else 0.5 * sum(limits)
        return sorted({float(f"{x:.3g}") for x in (*limits, middle, *inside)})

    shapes = rig.psi_set or tuple(float(x) for x in response.shapes)
    longest = float(np.clip(1.1 * np.max(asked[:, 3]), *rig.sd_set)) if "sd" in present else rig.sd_set[1]
    sigma = levels(rig.sigma_set, asked[:, 2], False)
    speed = levels(rig.v_set, asked[:, 0], True)
    tool = levels(rig.T_tool, asked[:, 1], False)
    names = ("sigma_set", "psi_set", "v_set", "T_tool", "sd_set")
    grid = product(sigma, shapes, speed, tool, (float(f"{longest:.3g}"),))
    rows = [dict(zip(names, row, strict=True)) for row in grid]
    if len(rows) > MOST_CANDIDATES:
        kept = np.unique(np.linspace(0, len(rows) - 1, MOST_CANDIDATES).round().astype(int))
        rows = [rows[k] for k in kept]
    return rows


def _inside(regions: list[Region], loads: FloatArray) -> np.ndarray:
    """Return which states lie inside of each region, shape (regions, n)."""
    return np.array([region.contains(natural_columns(loads, region.names)) for region in regions])


def _corners(regions: list[Region], tested: FloatArray) -> dict[tuple[str, ...], FloatArray]:
    """Return the corners of every region: a hull of them and of new points is the hull of all."""
    corners: dict[tuple[str, ...], FloatArray] = {}
    for region in regions:
        if region.outline is not None:
            corners[region.names] = region.outline
        else:
            column = natural_columns(tested, region.names)
            corners[region.names] = np.array([[column.min()], [column.max()]])
    return corners


def _unreachable(
    asked: FloatArray,
    reachable: np.ndarray,
    work: FloatArray,
    all_points: FloatArray,
    present: tuple[str, ...],
) -> list[str]:
    """Say for each load which part lies beyond everything that the rig can do."""
    said = []
    for name in present:
        j = LOAD_NAMES.index(name)
        low, high = float(all_points[:, j].min()), float(all_points[:, j].max())
        region = Region.of((name,), natural_columns(all_points, (name,)))
        outside = ~region.contains(natural_columns(asked, (name,)))
        for side, limit, where in (("below", low, asked[:, j] < low), ("above", high, asked[:, j] > high)):
            share = float(work @ (outside & where))
            if share >= WORTH:
                said.append(
                    f"{name} {side} {limit:.4g}{behind(LOADS[j].unit)}: {100 * share:.1f} % of the friction work"
                )
    left = float(work @ ~reachable.all(axis=0))
    if left >= WORTH:
        said.append(f"{100 * left:.1f} % of the friction work by load or pair of loads in all")
    return said
