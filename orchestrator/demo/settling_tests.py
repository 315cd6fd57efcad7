"""Tests that settle an ambiguous answer: those that the diagnosis proposes, run in the virtual laboratory."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from friction_models import load_model
from friction_models.common import write_json
from friction_models.common.files import read_json
from friction_models.discovery import diagnose
from friction_models.discovery.answer.changes import changes_text
from friction_models.discovery.further_tests.joined import join_campaigns
from friction_models.loads import DataSet

from ..jobs.job import Progress
from ..report.sections.demo_folder import SettlingRound

#: Folder of the further tests, and what they changed.
FURTHER, SETTLED = "further", "settled.json"
#: What is kept of a proposal.
PROPOSED = ("protocol", "setpoints", "separates", "expected_t", "entropy_reduction", "tests")
#: Most rounds of further tests.
ROUNDS = 3


def settle(out: Path, seed: int, jobs: int | None, tick: Progress) -> None:
    """Run what is proposed, the most telling proposal each time, until one name is left; write ``settled.json``.

    `out` is the folder of the demo, with the first diagnosis; `seed` that of the diagnosis, of specimens and noise.
    """
    from sct_twin import SctTwin
    from sct_twin.virtual_lab import run_protocol

    found = read_json(out / "diagnosis.json")
    model = load_model(out / "models" / "before")
    rounds: list[SettlingRound] = []
    while len(found["confusion_set"]) > 1 and found["next_tests"] and len(rounds) < ROUNDS:
        number = len(rounds) + 1
        proposed = found["next_tests"][0]
        tick(number - 1, ROUNDS, proposed["protocol"])
        folder = out / FURTHER / f"campaign-{number}"
        run_protocol(out / "campaign", proposed["plan"], out=folder, seed=seed + 1000 * number, jobs=jobs)
        SctTwin().run(folder, out=out / FURTHER / f"data-{number}", jobs=jobs)
        data = all_tests(out, number).select("train")
        after = diagnose(data.points, data.tests, model=model, seed=seed)
        rounds.append(
            cast(
                SettlingRound,
                {
                    **{key: proposed[key] for key in PROPOSED},
                    "before": found["confusion_set"],
                    "after": after.confusion_set,
                    "changed": changes_text(found, after),
                },
            )
        )
        found = after.to_dict()
    write_json(out / SETTLED, {"diagnosis": found, "rounds": rounds})


def all_tests(out: Path, rounds: int) -> DataSet:
    """Return the tests of the demo's campaign and of so many rounds of further ones."""
    parts = {"data": DataSet.load(out / "data")}
    parts |= {f"further {k}": DataSet.load(out / FURTHER / f"data-{k}") for k in range(1, rounds + 1)}
    return join_campaigns(parts)[0]
