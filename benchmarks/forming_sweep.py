"""Whether forming runs end: 200 random valid set-ups of both processes, each one kept as it ends."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypedDict

import numpy as np

from forming import BackwardCupExtrusion, ForwardRodExtrusion
from forming.results.result import FormingResult
from friction_models.common import InputError, write_json

from .common import Section, Table, section
from .data import sources

COUNT = 200
SEED = 4
#: Container diameter [mm].
DIAMETER = 20.0


KINDS: dict[str, Callable[..., ForwardRodExtrusion | BackwardCupExtrusion]] = {
    "fre": ForwardRodExtrusion,
    "bce": BackwardCupExtrusion,
}


class Run(TypedDict, total=False):
    """A set-up, with the arguments of one process or the other, and how it ended; as its file keeps it.

    ``stroke`` is the one asked for, and where there is a result, the one reached.
    """

    mu: float
    T_billet: float
    T_tool: float
    speed: float
    land: float
    process: str
    stroke: float
    half_angle: float
    exit_diameter: float
    entry_radius: float
    punch_diameter: float
    nose_angle: float
    edge_radius: float
    relief: float
    number: int
    ending: str
    reason: str
    asked: float
    force: float
    energy: float
    volume: float
    ripple: float
    increments: int
    failed: int
    seconds: float


def setup(number: int) -> Run:
    """Return the set-up of this number: the same one always, whatever was run before it."""
    rng = np.random.default_rng([SEED, number])
    reduction = float(rng.uniform(0.15, 0.75))
    drawn: Run = {
        "mu": float(rng.uniform(0.0, 0.2)),
        "T_billet": float(rng.uniform(20.0, 300.0)),
        "T_tool": float(rng.uniform(20.0, 300.0)),
        "speed": float(np.exp(rng.uniform(0.0, np.log(500.0)))),
        "land": float(rng.uniform(1.0, 4.0)),
    }
    if number % 2 == 0:
        return {
            **drawn,
            "process": "fre",
            "stroke": 20.0,
            "half_angle": float(rng.uniform(15.0, 75.0)),
            "exit_diameter": float(DIAMETER * np.sqrt(1.0 - reduction)),
            "entry_radius": float(rng.uniform(0.5, 4.0)),
            "edge_radius": float(rng.uniform(0.5, 3.0)),
            "relief": float(rng.uniform(0.2, 2.0)),
        }
    return {
        **drawn,
        "process": "bce",
        "stroke": 14.0,
        "punch_diameter": float(DIAMETER * np.sqrt(reduction)),
        "edge_radius": float(rng.uniform(0.5, 2.5)),
        "nose_angle": float(rng.choice([0.0, rng.uniform(2.0, 15.0)])),
        "relief": float(rng.uniform(0.05, 0.5)),
    }


def attempt(drawn: Run) -> Run:
    """Run a set-up and say how it ended: at its stroke, refused, stopped, crashed or not finite."""
    given = {k: v for k, v in drawn.items() if k not in ("process", "mu", "stroke")}
    began = time.process_time()
    found: Run = {**drawn, "ending": "at its stroke", "reason": ""}
    try:
        process = KINDS[drawn["process"]](**given, diameter=DIAMETER)
        found["asked"] = min(drawn["stroke"], process.max_stroke)
        result = process.run(drawn["mu"], found["asked"])
    except InputError as error:
        found["ending"], found["reason"] = "refused", str(error)
    except Exception as error:  # a crash is a result of this measurement
        found["ending"], found["reason"] = "crashed", f"{type(error).__name__}: {error}"
    else:
        _judge(result, found)
    found["seconds"] = time.process_time() - began
    return found


def _judge(result: FormingResult, found: Run) -> None:
    """Note ending and numbers of a run that gave a result."""
    contact = result.contact
    finite = all(
        np.isfinite(values).all()
        for values in (result.force, result.work, contact.loads, contact.mu, contact.position)
    )
    ending = "at its stroke" if result.status == "ok" else "stopped"
    found["ending"], found["reason"] = ending if finite else "not finite", result.message
    found["stroke"], found["force"] = float(result.stroke[-1]), result.max_force
    found["energy"], found["volume"] = result.energy_balance, result.volume_change
    found["ripple"] = result.force_ripple()[1]
    found["increments"], found["failed"] = result.increments, result.failed_increments


def measure(folder: Path) -> Section:
    """Run or read all set-ups."""
    attempt({**setup(1), "stroke": 0.2})
    attempt({**setup(0), "stroke": 0.2})
    kept = folder / "sweep" / sources("forming")
    runs = [_one(kept, number) for number in range(COUNT)]
    return report(runs)


def _one(kept: Path, number: int) -> Run:
    file = kept / f"{number}.json"
    if file.is_file():
        found: Run = json.loads(file.read_text(encoding="utf-8"))
        return found
    run: Run = {**attempt(setup(number)), "number": number}
    write_json(file, run)
    print(
        f"sweep {number}: {run['process']} {run['ending']} in {run['seconds']:.1f} s {run['reason']}",
        flush=True,
    )
    return run


def report(runs: list[Run]) -> Section:
    """Return the section: how many ended where, then every set-up."""
    summary = Table(
        ["process", "set-ups", "at their stroke", "refused", "stopped", "crashed or not finite", "CPU time, median [s]",
         "CPU time, worst [s]", "energy imbalance, worst [%]", "volume change, worst [%]",
         "force ripple, median [%]", "force ripple, worst [%]"]
    )  # fmt: skip
    for name in ("fre", "bce"):
        of = [r for r in runs if r["process"] == name]
        count = {e: sum(r["ending"] == e for r in of) for e in ("at its stroke", "refused", "stopped")}
        energy = max((abs(r.get("energy", 0.0)) for r in of), default=0.0)
        volume = max((abs(r.get("volume", 0.0)) for r in of), default=0.0)
        times = [r["seconds"] for r in of]
        ripples = [r.get("ripple", 0.0) for r in of] or [0.0]
        summary.rows.append(
            (name, len(of), *count.values(), len(of) - sum(count.values()), f"{np.median(times):.1f}",
             f"{max(times):.1f}", f"{100 * energy:.3f}", f"{100 * volume:.3f}",
             f"{100 * np.median(ripples):.2f}", f"{100 * max(ripples):.2f}")
        )  # fmt: skip
    every = Table(
        ["set-up", "process", "half angle or nose [degrees]", "reduction [%]", "mu", "T billet [degC]", "T tool [degC]",
         "speed [mm/s]", "ending", "stroke [mm]", "force [kN]", "failed increments", "energy imbalance [%]", "ripple [%]", "CPU time [s]", "reason"]
    )  # fmt: skip
    for r in runs:
        bore = r.get("exit_diameter") or r["punch_diameter"]
        share = (bore / DIAMETER) ** 2
        every.rows.append(
            (r["number"], r["process"], f"{r['half_angle'] if 'half_angle' in r else r['nose_angle']:.0f}",
             f"{100 * (share if r['process'] == 'bce' else 1 - share):.0f}", f"{r['mu']:.3f}", f"{r['T_billet']:.0f}",
             f"{r['T_tool']:.0f}", f"{r['speed']:.3g}", r["ending"], f"{r.get('stroke', 0.0):.2f}",
             f"{r.get('force', 0.0):.0f}", r.get("failed", 0), f"{100 * r.get('energy', 0.0):.2f}",
             f"{100 * r.get('ripple', 0.0):.2f}", f"{r['seconds']:.1f}", r["reason"])
        )  # fmt: skip
    ended = sum(r["ending"] == "at its stroke" for r in runs)
    return section(
        "Sweep over forming set-ups",
        f"{ended} of {len(runs)} random valid set-ups ended at their stroke (asked for: at least 98 %). Container "
        f"{DIAMETER:g} mm, half die angle 15 to 75 degrees, reduction 15 to 75 %, mu 0 to 0.2, billet and tools 20 to "
        "300 degC on their own, 1 to 500 mm/s, radii, lands, reliefs and punch noses drawn, too; 20 mm of forward and "
        "14 mm of backward extrusion, or what the billet allows; tool temperature fields included. Ripple: farthest from a "
        "polynomial of degree 5 over the second half of the stroke, averaged force, % of its maximum; it holds a force that "
        "still changes its course, too. One core at low priority.",
        summary,
        every,
    )
