"""Material markers on the workpiece surface: the same material points through every remeshing."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import njit

from .mesh.polyline import CORNER, arc_length, turns
from .mesh.shape import FloatArray, IntArray
from .surface_loads import SurfaceLoads

#: Turns of the undeformed surface beyond this angle are corners of the billet: it consists of straight lines.
EDGE = np.radians(10.0)

#: Pressure of the last node of a contact over that of the node before, where a straight fall to zero just reaches the next one.
FALL = 0.41


class SurfaceMarkers:
    """A fixed number of material points on the surface, ordered from the lower to the upper axis point.

    Nodes move with the material, and a marker moves between them on a smooth curve, so that its path hardly
    depends on where the nodes are; at a remeshing it keeps its arc length. The sliding distance is summed at the marker.

    The surface expansion is that of ring areas: the area of revolution between neighbouring points of the
    material now over that area in the undeformed billet, so no error accumulates. Beside the markers the
    corners of the undeformed billet are such points. An interval therefore lies on one surface, on the face
    or on the side. A marker tells the expansion of its two intervals together. One at a corner belongs to
    both surfaces, and its expansion is that of the one in contact.

    - `surface`, shape (n_s, 2): undeformed surface.
    - `arc`, shape (n,): increasing arc lengths of the markers on it [mm].
    """

    def __init__(self, surface: FloatArray, arc: FloatArray, T: float) -> None:
        n = len(arc)
        lengths = arc_length(surface)
        corners, near = lengths[turns(surface) > EDGE], 1e-6 * lengths[-1]
        between = corners[_distance(corners, arc) > near]
        order = np.argsort(np.append(arc, between), kind="stable")
        points = np.append(arc, between)[order]
        #: Index coordinates of markers and corners: node number plus fraction of the edge.
        self.track = _index_coordinate(points, lengths)
        self._own = np.flatnonzero(order < n)
        self._is_corner = _distance(points, corners) < near
        #: Areas of the intervals at the start [mm2].
        self.start_areas = self.areas(surface)
        self.start_arc = arc.copy()
        self.sd = np.zeros(n)
        self.psi = np.ones(n)
        self.v_rel = np.zeros(n)
        self.sigma_n = np.zeros(n)
        self.T = np.full(n, float(T))
        self.active = np.zeros(n, dtype=bool)

    def __len__(self) -> int:
        return len(self._own)

    @property
    def position(self) -> FloatArray:
        """Index coordinates of the markers: node number plus fraction of the edge."""
        return self.track[self._own]

    def at_markers(self, nodal: FloatArray) -> FloatArray:
        """Return a nodal quantity of the surface at the markers."""
        k, u = _edges(self.position)
        return (1.0 - u) * nodal[k] + u * nodal[k + 1]

    def at_nodes(self, values: FloatArray, n_nodes: int) -> FloatArray:
        """Return a quantity of the markers at the `n_nodes` surface nodes."""
        return np.interp(np.arange(n_nodes), self.position, values)

    def points(self, surface: FloatArray) -> FloatArray:
        """Return the positions of the markers, shape (n, 2) [mm]."""
        return _points(surface, self.position)

    def corners(self, surface: FloatArray) -> FloatArray:
        """Return where the corners of the undeformed billet are now, in their order, shape (m, 2) [mm]."""
        return _points(surface, self.track[self._is_corner])

    def areas(self, surface: FloatArray, until: float = np.inf) -> FloatArray:
        """Return the areas of the intervals between neighbouring markers and corners [mm2].

        - `until`: index coordinate at which the surface is taken to end.
        """
        return np.diff(_area_below(surface, np.minimum(self.track, until)))

    def start_shares(self) -> FloatArray:
        """Return the undeformed area that each marker stands for, shape (n,) [mm2].

        It reaches half way to the next marker on the same surface of the billet, and up to the corner where there is
        none: what lies beyond a corner slides along another tool, or along none.
        """
        own = np.isin(np.arange(len(self.track)), self._own)
        shares = np.zeros(len(self.track))
        for side, other in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
            shares[side] += np.where(own[other], 0.5, 1.0) * self.start_areas
        return shares[self._own]

    def follow(self, before: FloatArray, after: FloatArray) -> None:
        """Follow the motion of the surface nodes in an increment, shapes (n_s, 2).

        With straight lines between the nodes every edge would stretch evenly, and the expansion would depend
        on where the nodes were in every increment, that is on the number of remeshings.
        """
        old, new = arc_length(before), arc_length(after)
        arc = np.interp(self.track, np.arange(len(old)), old)
        self.track = _index_coordinate(_smooth(old, new, turns(after) > CORNER, arc), new)

    def update(
        self,
        surface: FloatArray,
        T: FloatArray,
        loads: SurfaceLoads,
        dt: float,
        shares: FloatArray | None = None,
    ) -> None:
        """Take over the state at the end of an increment `dt` [s]; `T` are the temperatures of the surface nodes.

        Markers in contact get new loads; the others keep v_rel, sigma_n and T of their last contact. Those that did not touch
        a tool before slide for the share of the increment that `shares` has for them at each tool, shape (n_tools, n). The
        contact temperature is the mean of workpiece and tool surface. The tool is that which the edge of the surface
        with the marker faces; a marker at a node sees that which presses harder of its two.
        """
        k, u = _edges(self.track)
        k, u = _beside(k, u, loads)
        tool = loads.faced[k]
        first, second = (np.where(tool >= 0, loads.pressures[tool, node], 0.0) for node in (k, k + 1))
        w0, w1 = (1.0 - u) * (first > 0.0), u * (second > 0.0)
        weight, pressure = w0 + w1, (1.0 - u) * first + u * second
        touches = (weight >= 1.0 - _reach(k, tool, loads.pressures)) & (pressure > 0.0)
        self.psi = self._expansion(surface, loads.active)[self._own]
        before, self.active = self.active, touches[self._own]
        on = self.active
        at = self._own[on]
        slip, tool_T = (
            (w0[at] * f[tool[at], k[at]] + w1[at] * f[tool[at], k[at] + 1]) / weight[at]
            for f in (np.abs(loads.slips), loads.temperatures)
        )
        self.v_rel[on] = slip
        self.sigma_n[on] = pressure[at]
        self.T[on] = 0.5 * (self.at_markers(T)[on] + tool_T)
        lasts = np.ones(len(at))
        if shares is not None:
            lasts = np.where(before[on], 1.0, shares[tool[at], on])
        self.sd[on] += slip * lasts * dt

    def _expansion(self, surface: FloatArray, active: npt.NDArray[np.bool_]) -> FloatArray:
        """Return dA/dA0 over both intervals of a point; at a corner over those beside which a node is `active`."""
        share = np.ones((2, len(self.track)))
        corner = self.track[self._is_corner]
        share[0, self._is_corner] = active[np.ceil(corner - 1e-6).astype(np.int64) - 1]
        share[1, self._is_corner] = active[np.floor(corner + 1e-6).astype(np.int64) + 1]
        share[:, share.sum(axis=0) == 0.0] = 1.0
        now, start = (
            share[0] * np.append(0.0, areas) + share[1] * np.append(areas, 0.0)
            for areas in (self.areas(surface), self.start_areas)
        )
        return now / start

    def move_to(self, old_surface: FloatArray, old_arc_of_new_nodes: FloatArray) -> None:
        """Follow a remeshing: new nodes stood at `old_arc_of_new_nodes` on the old surface."""
        old = arc_length(old_surface)
        arc = np.interp(self.track, np.arange(len(old)), old)
        self.track = _index_coordinate(arc, old_arc_of_new_nodes)

    def loads(self) -> FloatArray:
        """Return v_rel, T, sigma_n, sd, psi of the markers, shape (n, 5)."""
        return np.column_stack([self.v_rel, self.T, self.sigma_n, self.sd, self.psi])


def _points(surface: FloatArray, index: FloatArray) -> FloatArray:
    """Return the points of the surface at rising index coordinates, shape (n, 2)."""
    k, u = _edges(index)
    return (1.0 - u)[:, None] * surface[k] + u[:, None] * surface[k + 1]


def _distance(points: FloatArray, others: FloatArray) -> FloatArray:
    """Return how far each number is from the nearest of the others."""
    return np.asarray(np.abs(points[:, None] - others[None, :]).min(axis=1, initial=np.inf))


def _index_coordinate(arc: FloatArray, node_arc: FloatArray) -> FloatArray:
    """Return node index plus fraction of the edge for points at given arc lengths."""
    return np.interp(arc, node_arc, np.arange(len(node_arc), dtype=np.float64))


def _edges(index: FloatArray) -> tuple[npt.NDArray[np.int64], FloatArray]:
    """Return edge and place on it, 0 to 1, of points at rising index coordinates."""
    last = max(int(np.ceil(index[-1] - 1e-9)) - 1, 0)
    k = np.minimum(index.astype(np.int64), last)
    return k, index - k


def _beside(
    k: npt.NDArray[np.int64], u: FloatArray, loads: SurfaceLoads
) -> tuple[npt.NDArray[np.int64], FloatArray]:
    """Return edge and place on it of points; one at a node goes to the edge whose tool presses harder there."""
    k, u = k.copy(), u.copy()
    for start, other, place in ((True, -1, 1.0), (False, 1, 0.0)):
        at = np.flatnonzero((u < 1e-6) & (k > 0) if start else (u > 1.0 - 1e-6) & (k < len(loads.faced) - 1))
        node = k[at] if start else k[at] + 1
        own, next_to = loads.faced[k[at]], loads.faced[k[at] + other]
        harder = np.where(next_to >= 0, loads.pressures[next_to, node], 0.0) > np.where(
            own >= 0, loads.pressures[own, node], 0.0
        )
        u[at[harder]] = place
        k[at[harder]] += other
    return k, u


def _reach(k: npt.NDArray[np.int64], tool: IntArray, pressures: FloatArray) -> FloatArray:
    """Return how far a contact reaches into edges of which one node touches, as a share of them, shape (n,).

    Where a pressure falls straight to zero within the edge, its last node carries (0.4 d + 0.6 d^2 - 0.2 d^3) / (1 + d)
    of that before, d being the share: `FALL` d, up to `FALL`. Else a marker that rides along with the end of a light contact
    would rub for a whole stroke, or not at all, as the mesh has it. A contact that ends abruptly reaches half of the edge.

    - `k`, `tool`, shape (n,): edges, and the tools that they face.
    """
    # Beyond both ends of the surface stands nothing.
    known = np.zeros((pressures.shape[0], pressures.shape[1] + 4))
    known[:, 2:-2] = pressures
    ends_here = known[tool, k + 2] > 0.0
    last, before, first = (
        np.where(ends_here, known[tool, k + 2 - i], known[tool, k + 3 + i]) for i in range(3)
    )
    falls = (first > before) & (last < FALL * before)
    return np.where(falls, last / np.where(falls, FALL * before, 1.0), 0.5)


def _area_below(surface: FloatArray, index: FloatArray) -> FloatArray:
    """Return the surface area from the start of the chain to points at index coordinates [mm2]."""
    r = surface[:, 0]
    length = np.diff(arc_length(surface))
    below = np.concatenate([[0.0], np.cumsum(length * (r[1:] + r[:-1]) * np.pi)])
    k, u = _edges(index)
    return below[k] + 2.0 * np.pi * length[k] * u * (r[k] + 0.5 * u * (r[k + 1] - r[k]))


@njit(cache=True)
def _smooth(x: FloatArray, y: FloatArray, broken: npt.NDArray[np.bool_], at: FloatArray) -> FloatArray:
    """Interpolate a rising function by cubics whose slopes are those of parabolas through three neighbouring nodes.

    - `x`, `y`, shape (n,): nodes and values, both rising.
    - `broken`, shape (n,): nodes at which the slope may jump; the ends are such nodes, too.
    - `at`, shape (m,): rising.
    """
    n = x.shape[0]
    slope = np.zeros(n)
    for i in range(1, n - 1):
        before, after = x[i] - x[i - 1], x[i + 1] - x[i]
        rise = (y[i] - y[i - 1]) / before * after + (y[i + 1] - y[i]) / after * before
        slope[i] = rise / (before + after)
    found = np.empty(at.shape[0])
    k = 0
    for p in range(at.shape[0]):
        while k < n - 2 and x[k + 1] <= at[p]:
            k += 1
        h = x[k + 1] - x[k]
        secant = (y[k + 1] - y[k]) / h
        at_start, at_end = k == 0 or broken[k], k == n - 2 or broken[k + 1]
        first = slope[k] if not at_start else secant if at_end else 2.0 * secant - slope[k + 1]
        last = slope[k + 1] if not at_end else secant if at_start else 2.0 * secant - slope[k]
        # Between 0 and three times the secant the curve cannot turn back (Fritsch and Carlson 1980).
        first, last = min(max(first, 0.0), 3.0 * secant), min(max(last, 0.0), 3.0 * secant)
        u = (at[p] - x[k]) / h
        bend = u * (1.0 - u) * ((1.0 - u) * (first - secant) - u * (last - secant))
        found[p] = y[k] + h * (u * secant + bend)
    return found
