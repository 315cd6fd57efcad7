"""Forward rod extrusion in co-simulation: run time, increments, what the coupling costs."""

from __future__ import annotations

import time
from pathlib import Path

from fmus import pack, pack_forming
from forming import ForwardRodExtrusion
from friction_models import ConstantFriction
from orchestrator import Master
from orchestrator.cosim.ready_made import extrusion_system

from .common import Section, Table, section
from .data import models
from .master_overhead import coupled_step, overhead


def measure(folder: Path) -> Section:
    """Run the reference extrusion alone and coupled with each friction FMU."""
    ForwardRodExtrusion().run(0.08, stroke=0.5)  # compiles, or loads what is compiled
    alone = Table(
        ["mu", "maximum force [kN]", "time [s]", "increments", "remeshes", "energy balance", "max tau/k"]
    )
    for mu in (0.0, 0.04, 0.08, 0.12):
        began = time.perf_counter()
        result = ForwardRodExtrusion().run(mu)
        alone.rows.append(
            (
                f"{mu:.2f}",
                f"{result.max_force:.1f}",
                f"{time.perf_counter() - began:.2f}",
                result.increments,
                result.remeshes,
                f"{100 * result.energy_balance:+.2f} %",
                f"{result.max_tau_over_k:.2f}",
            )
        )
    coupled = Table(
        ["friction FMU (80 nodes)", "maximum force [kN]", "run [s]", "forming", "friction", "master", "friction + master a step [us]"]
    )  # fmt: skip
    place = folder / "coupling"
    forming = pack_forming(place / "forming.fmu")
    for name, model in {"constant 0.08": ConstantFriction(0.08), **models(folder)}.items():
        friction = pack(model, place / f"{name.split()[0]}.fmu", nodes=80)
        run = Master(extrusion_system(friction, forming, speed=5.0)).run(place / "run")
        t = run.manifest["timing_s"]
        loop = t["forming"] + t["friction"] + t["master"]
        coupled.rows.append(
            (
                name,
                f"{run['forming.force'].max():.1f}",
                f"{loop:.2f}",
                *(f"{100 * t[part] / loop:.2f} %" for part in ("forming", "friction", "master")),
                f"{1e6 * (t['friction'] + t['master']) / run.manifest['steps']:.0f}",
            )
        )
    return section(
        "Forward rod extrusion and its coupling",
        "Reference case: 20 to 14.14 mm, 2 alpha = 90 degrees, billet 30 mm, 5 mm/s, stroke 20 mm, one core, without compilation. "
        "Alone with constant friction, then as an FMU with a friction FMU at 80 material markers, 200 steps, one-step lag. "
        "Then: what the master adds to the C calls of a scalar friction FMU, other loads every step included in all rows, "
        "and a coupled step in this and other masters.",
        alone,
        coupled,
        overhead(place),
        coupled_step(place),
    )
