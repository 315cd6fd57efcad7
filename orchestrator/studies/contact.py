"""The contact of a forming run, marker by marker: areas, friction work, and how much of it exceeds a trained domain."""

from __future__ import annotations

from typing import NamedTuple, TypedDict

import numpy as np
import numpy.typing as npt

from friction_models.loads import LOAD_NAMES, LOADS, FloatArray
from friction_models.models.domain import Domain

from ..comparison.level_runs import FormingLevel
from ..cosim.run_folders import Run


def reference_areas(level: FormingLevel) -> FloatArray:
    """Return the area that every marker stands for on the undeformed billet [mm2], in the order of the run.

    It reaches half way to the neighbouring markers, or to a corner of the billet, and all around the axis (2 pi r ds).
    Markers are dense where the tools work on the billet, so these areas differ by a factor of a hundred and more. Times
    its surface expansion, which the solver takes over the same neighbours, it is the area that a marker stands for now.
    """
    process = level.forming()
    process.start()
    return process.simulation.state.markers.start_shares()


def by_marker(run: Run, label: str) -> FloatArray:
    """Return what a run recorded with a column for each marker, also where there is a single one."""
    return np.atleast_2d(run[label].T).T


class Share(TypedDict):
    """A part of the contact: its share of the area, and of the friction work."""

    share: float
    work: float


class Beyond(Share):
    """A part of the contact beyond a trained range, and how far: in the unit of the load, and in trained ranges."""

    median: float
    largest: float
    median_ranges: float


class Exceedance(TypedDict):
    """How much of the contact lies below and above the trained range of a load."""

    load: str
    unit: str
    trained: list[float]
    reached: list[float]
    below: Beyond
    above: Beyond


class Spread(TypedDict):
    """Percentiles over the contact area, and the largest value."""

    p5: float
    median: float
    p95: float
    largest: float


class Contact(NamedTuple):
    """Every marker in contact at every step of a run, n in all.

    Steps take the same time, so sums of areas are shares of contact and time.

    Examples
    --------
    Two markers of equal area; the first does three quarters of the work:

    >>> contact = Contact(np.zeros((2, 5)), np.array([0.1, 0.1]), np.array([1.0, 1.0]), np.array([3.0, 1.0]))
    >>> contact.share(np.array([True, False]))
    {'share': 0.5, 'work': 0.75}
    """

    loads: FloatArray  # shape (n, 5)
    mu: FloatArray  # answer of the friction model, shape (n,)
    area: FloatArray  # what the marker stands for, shape (n,) [mm2]
    work: FloatArray  # friction work on it during the step, shape (n,) [J]

    def share(self, where: npt.NDArray[np.bool_]) -> Share:
        """Return the share of contact area and of friction work that a mask picks."""
        total = float(self.work.sum())
        return {
            "share": float(self.area[where].sum() / self.area.sum()),
            "work": float(self.work[where].sum()) / total if total > 0.0 else 0.0,
        }

    @classmethod
    def of(cls, run: Run, areas: FloatArray) -> Contact:
        """Return the contact of a run whose markers stand for `reference_areas` on the undeformed billet."""
        # What a step publishes is answered by the mu of the next one; the last row has no answer.
        touching = (by_marker(run, "forming.active") > 0.5)[:-1]
        loads = np.column_stack([by_marker(run, f"forming.{name}")[:-1][touching] for name in LOAD_NAMES])
        mu = by_marker(run, "friction.mu")[1:][touching]
        first, seconds = (
            np.broadcast_to(a, touching.shape)[touching] for a in (areas, np.diff(run.time)[:, None])
        )
        v_rel, _, sigma_n, _, psi = loads.T
        area = first * psi
        return cls(loads, mu, area, 1e-3 * mu * sigma_n * v_rel * area * seconds)


def exceedance(k: int, contact: Contact, domain: Domain) -> Exceedance:
    """Return how much of the contact exceeds the trained range of one load, and by how much."""
    low, high, scale = domain.lower[k], domain.upper[k], float(domain.scale[k])
    values = contact.loads[:, k]
    return {
        "load": LOAD_NAMES[k],
        "unit": LOADS[k].unit,
        "trained": [low, high],
        "reached": [float(values.min()), float(values.max())],
        "below": _beyond(low - values, contact, scale),
        "above": _beyond(values - high, contact, scale),
    }


def _beyond(over: FloatArray, contact: Contact, scale: float) -> Beyond:
    out = over > 0.0
    share, beyond = contact.share(out), spread(over[out], contact.area[out])
    return {
        "share": share["share"],
        "work": share["work"],
        "median": beyond["median"],
        "largest": beyond["largest"],
        "median_ranges": beyond["median"] / scale,
    }


def spread(values: FloatArray, area: FloatArray) -> Spread:
    """Return percentiles over the contact area, and the largest value.

    Examples
    --------
    Of four markers, the one of the largest area decides the median:

    >>> spread(np.array([0.1, 0.2, 0.3, 0.4]), np.array([1.0, 1.0, 6.0, 1.0]))
    {'p5': 0.1, 'median': 0.3, 'p95': 0.4, 'largest': 0.4}
    """
    if not len(values):
        return {"p5": 0.0, "median": 0.0, "p95": 0.0, "largest": 0.0}
    order = np.argsort(values)
    below = np.cumsum(area[order])
    places = np.searchsorted(below, np.array([0.05, 0.5, 0.95]) * below[-1])
    p5, median, p95 = values[order][np.minimum(places, len(values) - 1)].tolist()
    return {"p5": p5, "median": median, "p95": p95, "largest": float(values.max())}
