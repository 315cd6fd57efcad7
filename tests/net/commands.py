"""The commands of the net: one loop through everything that writes files, on small synthetic data."""

from __future__ import annotations

from dataclasses import dataclass

FAMILIES = ("constant", "linear", "polynomial", "power_law", "gradient_boosting", "ffnn")
#: What is hidden in the campaigns, and the model that is diagnosed on each.
HIDDEN = {"stribeck": "linear", "thermal_breakdown": "power_law", "none": "polynomial"}
TARGETS = ("c", "ufric", "vfric", "table")

SYSTEM = """\
name: short extrusion
communication_step: 0.04
stop_time: 1.2
components:
  friction: {fmu: linear80.fmu}
  forming: {fmu: forming.fmu}
connections:
  - forming.v_rel -> friction.v_rel
  - forming.T -> friction.T
  - forming.sigma_n -> friction.sigma_n
  - forming.sd -> friction.sd
  - forming.psi -> friction.psi
  - friction.mu -> forming.mu
"""

PRESS = """\
from sct_twin import virtual_lab
virtual_lab.press_curves("stribeck/campaign", [(20.0, 5.0)], "press", processes=["fre"])
"""


@dataclass(frozen=True)
class Command:
    """Words of one command, in the folder of the net; `words[0] == "python"` runs Python code instead."""

    part: str
    words: tuple[str, ...]

    @property
    def name(self) -> str:
        """Words as one line."""
        return " ".join(self.words)


def commands() -> list[Command]:
    """Return all commands, each after those whose files it needs."""
    found: list[Command] = []

    def add(part: str, *lines: str) -> None:
        found.extend(Command(part, tuple(line.split())) for line in lines)

    for hidden in HIDDEN:
        effect = "" if hidden == "none" else f"--hidden {hidden}"
        add(
            "data",
            f"lab --plan reduced-27+10 {effect} --seed 7 -o {hidden}/campaign",
            f"twin {hidden}/campaign -o {hidden}/data",
        )
    add("data", "ingest stribeck/campaign --dry-run", "ingest stribeck/campaign -o ingested")
    data = "stribeck/data"
    for family in FAMILIES:
        add("models", f"train {family} --data {data} -o models/{family}")
        add("models", f"evaluate models/{family} --data {data} --json json/evaluate-{family}.json")
        add("models", f"predict models/{family} --data {data} -o predicted/{family}.csv")
    for hidden, model in HIDDEN.items():
        out = f"json/diagnose-{hidden}.json --report pages/diagnose-{hidden}.html"
        add(
            "discovery",
            f"diagnose --data {hidden}/data --model {model} --json {out} --plan next-{hidden}.csv",
        )
    add(
        "discovery",
        f"refine --data {data} --model linear --add stribeck -o models/refined --report pages/refined.html",
        "refine --data thermal_breakdown/data --model linear --add work_exhaustion --force -o models/remembers",
        f"compare --models models/linear models/refined 0.08 --data {data} --json json/compare.json "
        "--report pages/compare.html",
    )
    for family in (*FAMILIES, "refined", "remembers"):
        for fmi in ("2.0", "3.0"):
            add("fmus", f"pack models/{family} --fmi {fmi} -o fmus/{family}-{fmi}.fmu")
        add("fmus", f"check fmus/{family}-2.0.fmu", f"check fmus/{family}-3.0.fmu")
    add("fmus", "pack models/linear --fmi 3 --nodes 4 -o fmus/nodes.fmu")
    add("fmus", "pack models/linear --target python -o fmus/python.fmu", "check fmus/python.fmu")
    for target in TARGETS:
        add("fmus", f"pack models/polynomial --target {target} -o exports/{target}")
    add(
        "forming",
        "pack models/linear --nodes 80 -o linear80.fmu",
        "pack models/refined --nodes 80 -o refined80.fmu",
        "pack forming -o forming.fmu",
        "pack twin -o twin.fmu",
        "export system.yaml -o system.ssp",
        "simulate system.yaml -o runs/linear",
        "simulate system.yaml --swap friction=refined80.fmu -o runs/refined",
        "report runs/linear -o pages/run.html",
        "predict-sct models/linear --data stribeck/data --only sct028 --json json/predict-sct.json -o predicted-sct",
        "coverage --data stribeck/data --run runs/linear --json json/coverage.json --report pages/coverage.html",
    )
    found.append(Command("forming", ("python", PRESS)))
    add(
        "forming",
        "compare --models models/linear models/refined --press press --json json/compare-press.json",
        "attribute --press press --system system.yaml --runs attribution --causes stribeck "
        "--json json/attribute.json",
    )
    add("study", "study learning-curve --quick -o studies/learning-curve", "report studies/learning-curve")
    add("demo", "demo -o demo")
    return found
