"""Coverage map: which of the loads that a forming process puts on its contacts were ever tested.

A contact state is inside when each of its loads, and each pair of them, lies in the hull of the tested
points (with `TOLERANCE` of the range around it). A box would call a hot and slow contact tested where
only hot and fast ones were; the hull of the pair does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import TypedDict

import numpy as np
import numpy.typing as npt
import pandas as pd

from friction_models.common.imports.drawn import Drawn
from friction_models.loads import LOAD_NAMES, FloatArray
from friction_models.loads.contract import with_unit

from .contact_states import ContactStates

#: How far beyond the tested points a state still counts as tested, in tested ranges.
TOLERANCE = 0.02
#: Points of a test that take part: loads change slowly along it.
POINTS_OF_A_TEST = 40
#: Cells of a map along each load.
CELLS = 12
#: Slow speeds are told apart down to this one [mm/s].
SLOW = 0.5


def natural(name: str, values: npt.ArrayLike) -> FloatArray:
    """Return a load on the scale on which distances are judged: speed and expansion by their ratio.

    Examples
    --------
    >>> natural("T", [20.0, 80.0])
    array([20., 80.])
    >>> (natural("v_rel", [0.5, 1.5, 3.5]) - natural("v_rel", 0.5)) / np.log(2.0)
    array([0., 1., 2.])
    """
    array = np.asarray(values, dtype=np.float64)
    if name == "v_rel":
        return np.log(array + SLOW)
    if name == "psi":
        return np.log(np.maximum(array, 0.05))
    return array


@dataclass(frozen=True)
class Region:
    """What was tested of one load or of a pair: the hull of the tested points.

    Examples
    --------
    >>> region = Region.of(("T",), np.array([[20.0], [120.0]]))
    >>> region.contains(np.array([[80.0], [130.0]]))
    array([ True, False])
    """

    names: tuple[str, ...]
    low: FloatArray  # lower limit on the natural scale
    width: FloatArray  # range on the natural scale
    faces: FloatArray | None = None  # of a pair, shape (f, 3): a x + b y + c <= 0 inside, on the scaled range
    outline: FloatArray | None = None  # of a pair, shape (k, 2): corners of the hull on the natural scale

    @classmethod
    def of(cls, names: tuple[str, ...], tested: FloatArray) -> Region:
        """Return the region of tested points, shape (n, 1 or 2), natural scale."""
        low, high = tested.min(axis=0), tested.max(axis=0)
        size = np.maximum(np.abs(high), 1.0) * 1e-3
        width = np.where(high - low > 1e-9 * size, high - low, size)
        if len(names) == 1:
            return cls(names, low, width)
        from scipy.spatial import ConvexHull, QhullError

        scaled = (tested - low) / width
        try:
            hull = ConvexHull(scaled)
        except QhullError:  # all points on a line: give it the width of the tolerance
            step = TOLERANCE * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
            ends = scaled[[int(np.argmin(scaled @ [1, 1.3])), int(np.argmax(scaled @ [1, 1.3]))]]
            hull = ConvexHull((ends[:, None, :] + 0.05 * step[None]).reshape(-1, 2))
        corners = hull.points[hull.vertices] * width + low
        return cls(names, low, width, hull.equations, corners)

    def contains(self, points: FloatArray) -> npt.NDArray[np.bool_]:
        """Return which points, shape (n, 1 or 2), natural scale, lie inside."""
        scaled = (points - self.low) / self.width
        box = np.all((scaled >= -TOLERANCE) & (scaled <= 1.0 + TOLERANCE), axis=1)
        if self.faces is None:
            return np.asarray(box)
        far = scaled @ self.faces[:, :2].T + self.faces[:, 2]
        return np.asarray(box & np.all(far <= TOLERANCE, axis=1))


@dataclass(frozen=True)
class Share:
    """How much of a process lies outside what was tested, for one load or a pair (or all of them)."""

    names: tuple[str, ...]
    area: float
    work: float
    tested: tuple[tuple[float, float], ...] = ()  # smallest and largest of each load
    asked: tuple[tuple[float, float], ...] = ()

    def to_dict(self) -> dict[str, object]:
        """Return plain data."""
        return {
            "loads": list(self.names),
            "area_outside": self.area,
            "work_outside": self.work,
            "tested": [list(x) for x in self.tested],
            "process": [list(x) for x in self.asked],
        }


class Gain(TypedDict):
    """Share of contact area and friction work that a test would cover for one load, or a pair."""

    loads: list[str]
    share: float


class Proposal(TypedDict):
    """A test that would cover more: its settings, the rows of the test plan, and what it covers."""

    setpoints: dict[str, float]
    plan: list[dict[str, str | float]]
    covers: list[Gain]
    area_covered: float
    work_covered: float


@dataclass
class Coverage(Drawn):
    """Tested loads against the loads of a process.

    Examples
    --------
    A quarter of the contact area is hotter than anything that was tested:

    >>> points = pd.DataFrame({"test_id": "a", "v_rel": [5.0, 50.0], "T": [20.0, 100.0],
    ...                        "sigma_n": [500.0, 900.0], "sd": [0.0, 50.0], "psi": [1.0, 10.0]})
    >>> nan = float("nan")
    >>> loads = np.array([[nan, 60.0, nan, nan, nan], [nan, 300.0, nan, nan, nan]])
    >>> history = ContactStates(loads, np.array([0.75, 0.25]), np.array([0.5, 0.5]), "a made-up process")
    >>> found = coverage(points, history)
    >>> print(found.sentence)
    25 % of the contact area and 50 % of the friction work lie outside the tested loads, most of it by T.
    >>> found.loads[0].names, found.loads[0].area, found.loads[0].work
    (('T',), 0.25, 0.5)
    """

    history: ContactStates
    tested: FloatArray  # tested points, thinned, shape (n, 5)
    loads: list[Share]  # one for each load that the history holds
    pairs: list[Share]  # one for each pair of them, counted only where both lie inside by themselves
    whole: Share  # outside by any load or pair
    synthetic: bool
    #: Tests that would cover more, and what no test of the rig reaches; see `proposals.propose_tests`.
    proposals: list[Proposal] = field(default_factory=list)
    beyond_rig: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __repr__(self) -> str:
        return f"Coverage({self.sentence!r})"

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        area, work = 100 * self.whole.area, 100 * self.whole.work
        if max(area, work) < 0.5:
            return "All but 0.5 % of the contact lies within the tested loads."
        worst = max([*self.loads, *self.pairs], key=lambda s: max(s.work, s.area))
        return (
            f"{area:.0f} % of the contact area and {work:.0f} % of the friction work lie outside the tested loads, "
            f"most of it by {' with '.join(worst.names)}."
        )

    def to_dict(self) -> dict[str, object]:
        """Return what ``coverage --json`` writes."""
        return {
            "sentence": self.sentence,
            "synthetic": self.synthetic,
            "source": self.history.source,
            "tolerance": TOLERANCE,
            "outside": {"area": self.whole.area, "work": self.whole.work},
            "loads": [s.to_dict() for s in self.loads],
            "pairs": [s.to_dict() for s in self.pairs],
            "proposed_tests": self.proposals,
            "beyond_rig": list(self.beyond_rig),
            "notes": list(self.notes),
        }

    def report(self) -> str:
        """Return the text report, the result in one sentence first."""
        lines = [self.sentence, *(["(synthetic data)"] if self.synthetic else []), ""]
        lines.append(f"{'load':<14}{'tested':>22}{'process':>22}{'area outside':>15}{'work outside':>15}")
        for s in self.loads:
            tested, asked = ("{:.4g} to {:.4g}".format(*x[0]) for x in (s.tested, s.asked))
            lines.append(
                f"{with_unit(s.names[0]):<14}{tested:>22}{asked:>22}{100 * s.area:13.1f} %{100 * s.work:13.1f} %"
            )
        worst = [
            p for p in sorted(self.pairs, key=lambda p: -max(p.area, p.work)) if max(p.area, p.work) >= 5e-4
        ]
        lines += ["", "Combinations that were not tested, though each load alone was:"]
        lines += [
            f"{' with '.join(p.names):<58}{100 * p.area:13.1f} %{100 * p.work:13.1f} %" for p in worst[:6]
        ] or ["none"]
        if self.proposals:
            lines += [
                "",
                "Tests that would cover more (what each adds: mean of its shares of contact area and friction work)",
            ]
            for proposal in self.proposals:
                settings, gains = proposal["setpoints"], proposal["covers"]
                what = ", ".join(f"{' with '.join(x['loads'])} {100 * x['share']:.1f} %" for x in gains)
                lines.append(
                    f"  sigma_set {settings['sigma_set']:g} MPa, psi_set {settings['psi_set']:g}, v_set {settings['v_set']:g} mm/s, "
                    f"T_tool {settings['T_tool']:g} degC, sd_set {settings['sd_set']:g} mm: {what}"
                )
        if self.beyond_rig:
            lines += ["", "No test of the rig reaches"] + [f"  - {b}" for b in self.beyond_rig]
        if self.notes:
            lines += ["", "Note"] + [f"  - {n}" for n in self.notes]
        return "\n".join(lines) + "\n"


def coverage(points: pd.DataFrame, history: ContactStates, synthetic: bool = False) -> Coverage:
    """Compare the loads of a process with tested points, which may be `synthetic`."""
    tested = tested_points(points)
    regions = regions_of(tested, history.present)
    outside = {r.names: ~r.contains(natural_columns(history.loads, r.names)) for r in regions}
    alone = {r.names[0]: outside[r.names] for r in regions if len(r.names) == 1}
    loads, pairs = [], []
    for region in regions:
        where = outside[region.names]
        if len(region.names) == 2:
            where = where & ~alone[region.names[0]] & ~alone[region.names[1]]
            pairs.append(_share(history, region.names, where, tested))
        else:
            loads.append(_share(history, region.names, where, tested))
    any_of = np.any(list(outside.values()), axis=0)
    whole = Share((), float(history.area @ any_of), float(history.work @ any_of))
    return Coverage(
        history, tested, loads, pairs, whole, synthetic or history.synthetic, notes=list(history.notes)
    )


def tested_points(points: pd.DataFrame) -> FloatArray:
    """Return the loads of some points of every test, its ends included, shape (n, 5).

    Examples
    --------
    >>> points = pd.DataFrame({"test_id": ["a"] * 1000, **{name: np.arange(1000.0) for name in LOAD_NAMES}})
    >>> tested_points(points).shape
    (40, 5)
    """
    rows = []
    for _, index in points.groupby("test_id", sort=False).indices.items():
        chosen = np.unique(np.linspace(0, len(index) - 1, POINTS_OF_A_TEST).round().astype(int))
        rows.append(index[chosen])
    return points[list(LOAD_NAMES)].to_numpy(dtype=np.float64)[np.concatenate(rows)]


def regions_of(tested: FloatArray, present: Sequence[str]) -> list[Region]:
    """Return the tested region of each load and of each pair of loads.

    Examples
    --------
    >>> tested = np.array([[5.0, 20.0, 500.0, 0.0, 1.0], [50.0, 100.0, 900.0, 50.0, 10.0]])
    >>> [region.names for region in regions_of(tested, ("T", "sigma_n"))]
    [('T',), ('sigma_n',), ('T', 'sigma_n')]
    """
    names: list[tuple[str, ...]] = [*((n,) for n in present), *combinations(present, 2)]
    return [Region.of(n, natural_columns(tested, n)) for n in names]


def natural_columns(loads: FloatArray, names: tuple[str, ...]) -> FloatArray:
    """Return columns of loads, shape (n, 5), on the natural scale."""
    return np.column_stack([natural(n, loads[:, LOAD_NAMES.index(n)]) for n in names])


def _share(
    history: ContactStates, names: tuple[str, ...], where: npt.NDArray[np.bool_], tested: FloatArray
) -> Share:
    spans = []
    for table in (tested, history.loads):
        columns = [table[:, LOAD_NAMES.index(n)] for n in names]
        spans.append(tuple((float(c.min()), float(c.max())) for c in columns))
    return Share(names, float(history.area @ where), float(history.work @ where), spans[0], spans[1])


def cell_map(
    coverage: Coverage, first: str, second: str
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return edges along two loads (natural scale), and the shares of work and area in each cell.

    Their shapes are (m + 1,), (n + 1,), (n, m) and (n, m).
    """
    history = coverage.history
    both = [natural_columns(history.loads, (n,))[:, 0] for n in (first, second)]
    tested = [natural_columns(coverage.tested, (n,))[:, 0] for n in (first, second)]
    edges = [
        np.linspace(min(a.min(), b.min()), max(a.max(), b.max()) + 1e-12, CELLS + 1)
        for a, b in zip(both, tested, strict=True)
    ]
    work, _, _ = np.histogram2d(both[0], both[1], bins=(edges[0], edges[1]), weights=history.work)
    area, _, _ = np.histogram2d(both[0], both[1], bins=(edges[0], edges[1]), weights=history.area)
    return edges[0], edges[1], work.T, area.T
