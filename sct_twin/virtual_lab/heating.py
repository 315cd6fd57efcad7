"""Contact temperature of a virtual test: the laboratory's own thermal model, with mu fed back step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from friction_models.loads import FloatArray

from .contact.contact_state import LabContact
from .heat.rubbed_contact import RubbedContact
from .law import LawInput, TrueLaw
from .rig.drive import RATE
from .rig.specimen import Rig

#: A plate that stands longer than this has stopped [s].
_STANDS = 0.05
#: Steps of a rest, and of upsetting.
REST_STEPS, UPSETTING_STEPS = 14, 12
#: Friction never falls below this, whatever the scatter.
LEAST_MU_WITH_SCATTER = 0.002


@dataclass(frozen=True, eq=False)
class Sliding:
    """The sliding phase at its samples: force [N], speed [mm/s], distance [mm], scatter of mu."""

    F_n: FloatArray
    v: FloatArray
    sd: FloatArray
    scatter: FloatArray


def heat(
    state: LabContact,
    law: TrueLaw,
    context: Mapping[str, float],
    rig: Rig,
    T_tool: float,
    rise: FloatArray,
    wait: float,
    sliding: Sliding,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return contact temperature [degC], friction work per area [N/mm] and slip since the last stop [mm].

    - `rise`: how far the heat released by then would have warmed the specimen at the samples of upsetting [K].
    - `wait`: how long it lies on the plate before it slides [s].
    """
    contact = state.rubbed(T_tool, rig.thermal)
    upsetting = len(rise) / RATE
    warmer = np.interp(np.linspace(0.0, len(rise) - 1.0, UPSETTING_STEPS + 1), np.arange(len(rise)), rise)
    for more in np.diff(warmer):
        contact.warm(float(more))
        contact.advance(upsetting / UPSETTING_STEPS, 0.0, 0.0)
    for dt in np.diff(_rest_ends(wait)):
        contact.advance(float(dt), 0.0, 0.0)
    n = len(sliding.sd)
    T, work, slip = np.full(n, contact.means.mean), np.zeros(n), np.zeros(n)
    done = 0.0
    for begin, end, moves in _spans(sliding.v):
        span = slice(begin, min(end + 1, n))
        if moves:
            part = Sliding(*(values[span] for values in vars(sliding).values()))
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


def _rest_ends(seconds: float) -> FloatArray:
    """Return the instants at which the steps of a rest end [s], the shortest first."""
    return np.append(0.0, seconds * np.geomspace(1e-3, 1.0, REST_STEPS)) if seconds > 0.0 else np.zeros(1)


def _step_ends(cell: float, distance: float) -> FloatArray:
    """Return the distances at which steps end [mm]: a quarter more from step to step, up to half a cell."""
    growing = 0.05 * cell * 1.25 ** np.arange(11)
    ends = np.cumsum(np.minimum(growing, 0.5 * cell))
    even = max(2, int(np.ceil((distance - ends[-1]) / (0.5 * cell))) + 1)
    ends = np.append(ends, ends[-1] + 0.5 * cell * np.arange(1, even))
    return np.concatenate([[0.0], ends[ends < distance - 1e-9], [distance]])


def _stand(contact: RubbedContact, count: int) -> FloatArray:
    """Return the contact temperature at the samples of a stop."""
    edges = _rest_ends(max(count - 1, 1) / RATE)
    values = [contact.means.mean]
    for dt in np.diff(edges):
        values.append(contact.advance(float(dt), 0.0, 0.0).mean)
    return np.interp(np.arange(count) / RATE, edges, values)


def _slide(
    contact: RubbedContact,
    state: LabContact,
    law: TrueLaw,
    context: Mapping[str, float],
    part: Sliding,
    done: float,
) -> tuple[FloatArray, FloatArray]:
    """Return contact temperature and friction work at the samples of a part that slides."""
    sd = part.sd - part.sd[0]
    stops = _step_ends(contact.size, float(sd[-1]))
    t = np.interp(stops, sd, np.arange(len(sd)) / RATE)
    middle = 0.5 * (stops[1:] + stops[:-1])
    F_n, v, scatter = (np.interp(middle, sd, values) for values in (part.F_n, part.v, part.scatter))
    T, work = np.empty(len(stops)), np.zeros(len(stops))
    T[0], work[0] = contact.means.mean, done
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
