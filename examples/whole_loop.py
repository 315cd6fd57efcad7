"""From measurements to a better friction model in a forming simulation: the whole loop in Python.

Everything here is synthetic: the measurements come from the virtual laboratory.
Run it cell by cell, or whole: ``python examples/whole_loop.py``.
"""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from fmus import check, pack, pack_forming
from friction_models import FrictionModel, PolynomialFriction
from friction_models.common import InputError
from friction_models.discovery import compare, diagnose, refine
from orchestrator import Master, Run, System
from sct_twin import SctTwin, virtual_lab

FRE = """\
name: forward rod extrusion
communication_step: 0.02   # s, 0.1 mm at 5 mm/s
stop_time: {stop_time}
synthetic: true
components:
  friction: {{fmu: friction.fmu}}
  forming: {{fmu: forming.fmu}}
connections:
  - forming.v_rel -> friction.v_rel
  - forming.T -> friction.T
  - forming.sigma_n -> friction.sigma_n
  - forming.sd -> friction.sd
  - forming.psi -> friction.psi
  - friction.mu -> forming.mu
record: [forming.stroke, forming.force, forming.work, forming.max_tau_over_k]
"""


def first_accepted(train: pd.DataFrame, tests: pd.DataFrame | None, effects: list[str]) -> FrictionModel:
    """Return the linear model with the first of these effects that `refine` does not refuse."""
    for effect in effects:
        try:
            return refine(train, tests, model="linear", add=[effect])
        except InputError as refused:
            print(refused)
    raise RuntimeError(f"none of {', '.join(effects)} makes the linear model better")


def main(folder: Path, plan: str | pd.DataFrame = "reduced-27+10", stroke: float = 20.0) -> tuple[Run, Run]:
    """Run the loop in `folder`; return the co-simulations with the first and the refined model."""
    # %% Measurements, and the digital twin that adds the loads
    campaign = virtual_lab.Campaign(plan=plan, hidden="stribeck", seed=7).run(folder / "campaign")
    data = SctTwin().run(campaign).dataset()
    train, test = data.frames()

    # %% A first model, and what it misses
    model = PolynomialFriction(degree=2).fit_frame(train)
    print(compare({"polynomial": model}, test).report())
    diagnosis = diagnose(train, data.tests, model="linear")
    print(diagnosis.report())

    # %% The effect added; of several that the data cannot tell apart, the first that cross-validation accepts
    better = first_accepted(train, data.tests, diagnosis.confusion_set or diagnosis.effects or ["stribeck"])
    print(compare({"polynomial": model, "refined": better}, test).report())
    better.save(folder / "better")

    # %% Friction FMUs, swapped in a co-simulated forward rod extrusion
    first = pack(model, folder / "friction.fmu", nodes=80)
    refined = pack(better, folder / "better.fmu", nodes=80)
    pack_forming(folder / "forming.fmu", n_points=80)
    report = check(refined)
    if not report.ok:
        raise RuntimeError(str(report))
    (folder / "fre.yaml").write_text(FRE.format(stop_time=stroke / 5.0), encoding="utf-8")
    system = System.load(folder / "fre.yaml")
    before = Master(system.swap("friction", first)).run(folder / "runs" / "polynomial")
    after = Master(system.swap("friction", refined)).run(folder / "runs" / "refined")

    # %% The same stroke, two forces (compare with a press curve: `after.compare_force("press/level.csv")`)
    for run in (before, after):
        print(f"{run.name}: {run['forming.force'].max():.1f} kN")
    return before, after


# %%
if __name__ == "__main__":
    main(Path("build/whole_loop"))
