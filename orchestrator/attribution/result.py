"""What a forming attribution says: ranked causes, those that cannot be told apart, and its limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple, TypedDict

from friction_models.common.imports.drawn import Drawn
from friction_models.discovery.answer.wording import p_text
from friction_models.loads import FloatArray

#: What is named and still leaves this many times the scatter is not all that is missing.
LEFT = 2.0


class Strength(NamedTuple):
    """Strength of a cause with its standard error; `name` is empty for a cause with one strength."""

    name: str
    value: float
    error: float
    unit: str


class Deviation(TypedDict):
    """RMS of measured minus simulated force [kN]."""

    before: float
    after: float  # the first cause, and the second
    scatter: float  # to expect
    mesh: float  # shift by the mesh that is allowed beside the scatter


class LevelDeviation(TypedDict):
    """Measured minus simulated force of one level."""

    level: str
    stroke_mm: list[float]
    rms_kN: float


class LevelCurves(TypedDict):
    """What the page draws of one level: stroke [mm] and forces [kN]."""

    level: str
    stroke: FloatArray
    measured: FloatArray
    simulated: FloatArray
    after: FloatArray  # what is left after the causes named
    scatter: FloatArray  # to expect
    fingerprints: dict[str, FloatArray]  # by cause, change of the force for a strength of one


@dataclass(frozen=True)
class Fit:
    """Strength of one cause that fits best, alone.

    Examples
    --------
    >>> fit = Fit("flow_stress", "flow stress", "flow stress", (Strength("", 0.05, 0.01, "1"),), 120.0, 1e-9)
    >>> [round(limit, 4) for limit in fit.to_dict()["strength"][0]["interval"]]
    [0.0304, 0.0696]
    """

    cause: str
    kind: str
    title: str
    values: tuple[Strength, ...]
    gain: float
    p_value: float

    def to_dict(self) -> dict[str, object]:
        """Return plain data; the interval is that of the strength if this cause is the only one."""
        strengths = [
            {"name": n, "value": v, "interval": [v - 1.96 * e, v + 1.96 * e], "unit": u}
            for n, v, e, u in self.values
        ]
        return {
            "cause": self.cause,
            "kind": self.kind,
            "title": self.title,
            "strength": strengths,
            "gain": self.gain,
            "p_value": self.p_value,
        }


@dataclass
class Attribution(Drawn):
    """Where the force-stroke curves point to; an attribution, not a proof.

    Examples
    --------
    >>> strength = Strength("", 0.05, 0.01, "1")
    >>> found = Attribution(
    ...     ranking=[Fit("flow_stress", "flow stress", "flow stress", (strength,), 120.0, 1e-9)],
    ...     confusion_set=["flow_stress"], second=[], groups=[], unseen=["stroke_zero"],
    ...     deviation={"before": 8.0, "after": 3.0, "scatter": 1.0, "mesh": 0.0}, levels=[], synthetic=False,
    ... )
    >>> print(found.sentence)
    Attribution, not proof: the curves point to flow stress: flow_stress.
    >>> print(found.left)
    What is named leaves 3.0 times the scatter: something else is missing, too.
    """

    ranking: list[Fit]  # the largest gain first (drop of the whitened squared error less two a strength)
    #: Causes that these curves cannot tell from the first one, itself included; empty where nothing stands out.
    confusion_set: list[str]
    second: list[str]  # what is missing beside the first cause, where something is
    groups: list[list[str]]  # causes whose fingerprints are the same in these curves, whatever the truth
    unseen: list[str]  # causes that leave no trace in these curves
    deviation: Deviation
    levels: list[LevelDeviation]
    synthetic: bool
    warnings: list[str] = field(default_factory=list)
    curves: list[LevelCurves] = field(default_factory=list, repr=False)

    @property
    def kinds(self) -> list[str]:
        """Kinds of the causes in the confusion set."""
        by_name = {f.cause: f.kind for f in self.ranking}
        return list(dict.fromkeys(by_name[c] for c in self.confusion_set))

    def __repr__(self) -> str:
        return f"Attribution({self.sentence!r})"

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        if not self.confusion_set:
            return f"Attribution, not proof: the simulated curves lie {self.place}; no cause stands out."
        first = self.confusion_set[0]
        others = self.confusion_set[1:]
        text = f"the curves point to {' or '.join(self.kinds)}: {first}"
        if others:
            text += f", which they cannot tell from {', '.join(others)}"
        if self.second:
            text += f"; beside it {' or '.join(self.second)}"
        return f"Attribution, not proof: {text}."

    @property
    def place(self) -> str:
        """Where the simulated curves lie if no cause stands out."""
        d = self.deviation
        outside = d["before"] > LEFT * math.hypot(d["scatter"], d["mesh"])
        where = "outside the scatter of the measured ones, and no cause tried brings them nearer"
        return where if outside else "within the scatter of the measured ones"

    @property
    def left(self) -> str:
        """A sentence where what is named leaves far more than the scatter; or empty."""
        times = self.deviation["after"] / max(self.deviation["scatter"], 1e-9)
        if not self.confusion_set or times < LEFT:
            return ""
        return f"What is named leaves {times:.1f} times the scatter: something else is missing, too."

    def to_dict(self) -> dict[str, object]:
        """Return what ``attribute --json`` writes."""
        return {
            "label": "attribution, not proof",
            "sentence": self.sentence,
            "synthetic": self.synthetic,
            "kinds": self.kinds,
            "confusion_set": list(self.confusion_set),
            "second": list(self.second),
            "ranking": [f.to_dict() for f in self.ranking],
            "groups": [list(g) for g in self.groups],
            "unseen": list(self.unseen),
            "deviation_kN": dict(self.deviation),
            "levels": self.levels,
            "warnings": list(self.warnings),
        }

    def report(self) -> str:
        """Return the text report, the result in one sentence first."""
        d = self.deviation
        lines = [self.sentence, *(["(synthetic press curves)"] if self.synthetic else []), ""]
        lines.append(
            f"Deviation of the force (rms): {d['before']:.2f} kN, with what is named {d['after']:.2f} kN; "
            f"scatter to expect {d['scatter']:.2f} kN"
        )
        lines += [self.left] if self.left else []
        if d["mesh"] > 0.0:
            lines.append(
                f"Not judged: the part that looks like the difference of two meshes, up to about {d['mesh']:.2f} kN (rms)"
            )
        lines += [
            f"  {x['level']:<28} {x['rms_kN']:.2f} kN over {x['stroke_mm'][0]:.1f} to {x['stroke_mm'][1]:.1f} mm of stroke"
            for x in self.levels
        ]
        lines += ["", "Causes, each alone (gain: drop of the whitened squared error less 2 a strength)"]
        for f in self.ranking[:8]:
            values = ", ".join(
                f"{n + ' ' if n else ''}{v:+.3g} [{v - 1.96 * e:+.3g}, {v + 1.96 * e:+.3g}]{' ' + u if u != '1' else ''}"
                for n, v, e, u in f.values
            )
            lines.append(f"  {f.cause:<22}{f.kind:<13} gain {f.gain:9.1f}   p {p_text(f.p_value)}   {values}")
        if self.groups:
            lines += ["", "Not to be told apart by these curves, whatever the truth"]
            lines += [f"  {', '.join(g)}" for g in self.groups]
        if self.unseen:
            lines += ["", "Leaves no trace in these curves: " + ", ".join(self.unseen)]
        notes = [
            "friction effects are found on tribometer data (`diagnose`); force curves confirm them",
            *self.warnings,
        ]
        return "\n".join([*lines, "", "Note", *(f"  - {n}" for n in notes)]) + "\n"
