"""Which steps of the demo are taken as they are when it runs again."""

from __future__ import annotations

from pathlib import Path

import pytest

from friction_models.common.files import read_json
from orchestrator.demo import Demo


def done(out: Path, model: str) -> bool:
    """Do one step of a demo that writes a model; return whether it was done and not kept from before."""
    demo, worked = Demo(out), []
    if (out / "steps.json").is_file():
        demo._steps = read_json(out / "steps.json")

    def train(tick: object) -> None:
        worked.append(model)
        (out / "model").mkdir(exist_ok=True)
        (out / "model" / "card.json").write_text(model)

    demo._do("train", {"base": model}, ["model", "beside"], train)
    return bool(worked)


@pytest.mark.parametrize("replaced", [pytest.param("seed 8", marks=pytest.mark.nightly), ""])
def test_an_output_that_an_interrupted_run_has_replaced_is_made_again(tmp_path: Path, replaced: str) -> None:
    assert done(tmp_path, "seed 7")
    assert not done(tmp_path, "seed 7")
    # A run with another seed was killed when it had written its model, before the step was noted.
    (tmp_path / "model" / "card.json").write_text(replaced)
    assert done(tmp_path, "seed 7")
    assert (tmp_path / "model" / "card.json").read_text() == "seed 7"
    assert done(tmp_path, "seed 8")
