"""Contact temperature of a virtual test: the laboratory's own thermal model, with mu fed back step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from friction_models.loads import FloatArray

from ..twin.contact_temperature import SlidingContact
from ..twin.sliding import rest, rest_ends, step_ends
from ..twin.upsetting import ContactState
from .law import LawInput, TrueLaw
from .rig.drive import RATE
from .rig.specimen import Rig

#: A plate that stands longer than this has stopped [s].
_STANDS = 0.05
#: Friction never falls below this, whatever the scatter.
LEAST_MU_WITH_SCATTER = 0.002


@dataclass(frozen=True, eq=False)
class Sliding:
    """The sliding phase at its samples: force [N], speed [mm/s], distance [mm], scatter of mu, static share."""

    F_n: FloatArray
    v: FloatArray
    sd: FloatArray
    scatter: FloatArray
    static: FloatArray


def heat(
    state: ContactState,
    law: TrueLaw,
    context: Mapping[str, float],
    rig: Rig,
    T_tool: float,
    wait: float,
    sliding: Sliding,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return contact temperature [degC], friction work per area [N/mm] and slip since the last stop [mm]."""
    contact = state.sliding(float(sliding.v.max()), T_tool, T_tool, rig.thermal)
    rest(contact, wait)
    n = len(sliding.sd)
    T, work, slip = np.full(n, contact.contact.mean), np.zeros(n), np.zeros(n)
    done = 0.0
    for begin, end, moves in _spans(sliding.v):
        span = slice(begin, min(end + 1, n))
        if moves:
            part = Sliding(*(getattr(sliding, f)[span] for f in ("F_n", "v", "sd", "scatter", "static")))
            T[span], work[span] = _slide(contact, state, law, context, part, done)
            slip[span] = part.sd - part.sd[0]
            done = float(work[span][-1])
        else:
            T[span], work[span] = _stand(contact, span.stop - begin), done
    return T, work, slip


def _spans(v: FloatArray) -> list[tuple[int, int, bool]]:
    """Return (first, last, whether it moves) of the parts between stops; the start does not count as one."""
    still = np.concatenate([[False], v <= 0.0, [False]])
    edges = np.flatnonzero(still[1:] != still[:-1])
    stops = [
        (int(a), int(b) - 1)
        for a, b in zip(edges[::2], edges[1::2])
        if b - a > _STANDS * RATE and v[:a].any()
    ]
    spans, last = [], 0
    for first, end in stops:
        spans += [(last, first, True), (first, end, False)]
        last = end
    return [*spans, (last, len(v) - 1, True)]


def _stand(contact: SlidingContact, count: int) -> FloatArray:
    """Return the contact temperature at the samples of a stop."""
    edges = rest_ends(max(count - 1, 1) / RATE)
    values = [contact.contact.mean]
    for dt in np.diff(edges):
        values.append(contact.advance(float(dt), 0.0, 0.0).mean)
    return np.interp(np.arange(count) / RATE, edges, values)


def _slide(
    contact: SlidingContact,
    state: ContactState,
    law: TrueLaw,
    context: Mapping[str, float],
    part: Sliding,
    done: float,
) -> tuple[FloatArray, FloatArray]:
    """Return contact temperature and friction work at the samples of a part that slides."""
    sd = part.sd - part.sd[0]
    stops = step_ends(contact.cell, float(sd[-1]))
    t = np.interp(stops, sd, np.arange(len(sd)) / RATE)
    middle = 0.5 * (stops[1:] + stops[:-1])
    F_n, v, scatter = (np.interp(middle, sd, values) for values in (part.F_n, part.v, part.scatter))
    T, work = np.empty(len(stops)), np.zeros(len(stops))
    T[0], work[0] = contact.contact.mean, done
    slope = 0.0
    for k in range(len(middle)):
        step = stops[k + 1] - stops[k]
        sigma = float(F_n[k]) / state.area
        ahead = T[k] + 0.5 * slope * step
        load = LawInput(
            np.array([v[k]]),
            np.array([ahead]),
            np.array([sigma]),
            np.array([part.sd[0] + middle[k]]),
            np.array([state.psi]),
            np.array([work[k]]),
            context,
            np.array([middle[k]]),
        )
        mu = max(float(law.mu(load)[0] + scatter[k]), LEAST_MU_WITH_SCATTER)
        dt = max(float(t[k + 1] - t[k]), 1e-9)
        T[k + 1] = contact.advance(dt, step, mu * float(F_n[k]) * step / dt).mean
        slope = (T[k + 1] - T[k]) / step
        work[k + 1] = work[k] + mu * sigma * step
    return np.interp(sd, stops, T), np.interp(sd, stops, work)
