"""Metadata after SSP Traceability: what stands in it is what the card says, and the bytes depend on nothing else."""

from __future__ import annotations

import hashlib
import json
import zipfile
from pathlib import Path

import pytest
from lxml import etree

from fmus import pack
from fmus.interface.friction_source import FrictionSource
from fmus.source.reading import read_source
from fmus.source.traceability import PATH, SRMD, STC, traceability_files
from fmus.targets.packing import with_diagnosis
from friction_models import LinearFriction
from friction_models.common import InputError
from friction_models.discovery import diagnose, refine

from ..friction_models.made_up import campaign

CARD = {
    "author": "A & B",
    "data": {"points": 3, "tests": 2, "synthetic": True, "provenance": {"file": "a<b>.csv"}},
    "splits": {"by": "whole tests", "test": ["t1", "t2"], "digests": {"t2": "bb", "t1": "aa"}},
    "errors": {"held_out": {"rmse": 0.00123456789, "tests": 2}},
}


def entries(content: bytes) -> dict[str, str]:
    root = etree.fromstring(content)
    assert root.tag == f"{{{SRMD}}}SimulationResourceMetaData"
    # What the schema of the release candidate knows; the text of the specification has `generatingTool` instead.
    assert set(root.attrib) <= {"version", "name", "author", "generationTool", "generationDateAndTime"}
    return {e.get("keyword"): e.text for e in root.iter(f"{{{STC}}}ClassificationEntry")}


def source(card: dict[str, object]) -> FrictionSource:
    return FrictionSource(b"graph", "law.onnx", card=card, domain={"T": (20.0, 200.0)}, absent=("psi",))


def test_what_the_card_says_stands_in_the_file() -> None:
    content = traceability_files(source(CARD))[PATH]
    found = entries(content)
    assert found["data.points"] == "3" and found["data.synthetic"] == "true"
    assert found["data.provenance.file"] == "a<b>.csv" and etree.fromstring(content).get("author") == "A & B"
    assert found["split.test"] == "t1 t2" and found["error.held_out.rmse"] == "0.00123457"
    assert found["domain.T"] == "20 200" and found["domain.psi"] == "not measured"
    # The digest belongs to the data, not to the order in which the card lists the tests.
    other = {**CARD, "splits": {"digests": {"t1": "aa", "t2": "bb"}}}
    changed = {**CARD, "splits": {"digests": {"t1": "aa", "t2": "bc"}}}
    digests = [entries(traceability_files(source(c))[PATH])["data.sha256"] for c in (other, changed)]
    assert digests[0] == found["data.sha256"] != digests[1]


def test_time_comes_from_the_environment_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    assert etree.fromstring(traceability_files(source(CARD))[PATH]).get("generationDateAndTime") is None
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    told = etree.fromstring(traceability_files(source(CARD))[PATH]).get("generationDateAndTime")
    assert told == "1970-01-02T00:00:00Z"
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "today")
    with pytest.raises(InputError, match="SOURCE_DATE_EPOCH: 'today'"):
        traceability_files(source(CARD))


def test_a_model_without_a_card_has_no_such_file_and_odd_cards_are_taken() -> None:
    assert traceability_files(source({})) == {}
    odd = {"data": [], "splits": {"digests": 3}, "errors": {"test": 1}, "author": None}
    assert entries(traceability_files(source(odd))[PATH])["model.family"] == "onnx"
    assert entries(traceability_files(source({"data": {"points": "1\x00"}}))[PATH])["data.points"] == "1"


@pytest.mark.parametrize("target", ["native", "python"])
def test_packed_fmus_hold_it(target: str, tmp_path: Path) -> None:
    model = LinearFriction().fit_frame(campaign(tests=6, points=8))
    with zipfile.ZipFile(pack(model, tmp_path / "law.fmu", target=target)) as archive:
        found = entries(archive.read(PATH))
    card = read_source(model).card
    assert found["model.family"] == "linear" and found["data.points"] == str(card["data"]["points"])
    assert float(found["error.train.rmse"]) == pytest.approx(card["errors"]["train"]["rmse"], rel=1e-5)


def test_verdict_of_the_diagnosis_and_rounds_of_refinement_stand_in_the_packed_file(tmp_path: Path) -> None:
    points = campaign(tests=8, points=8)
    better = refine(points, model="constant", add="thermal_softening", force=True)
    answer = {
        "verdict": "explained",
        "sentence": "Thermal softening is missing <from> the model",
        "effects": ["thermal_softening"],
        "confusion_set": ["thermal_softening", "hersey"],
        "confidence": 0.75,
        "model": "constant",
        "synthetic": True,
        "error_budget": {},
        "ranking": [1, 2, 3],
    }
    (tmp_path / "answer.json").write_text(json.dumps(answer))
    path = pack(better, tmp_path / "law.fmu", target="python", diagnosis=tmp_path / "answer.json")
    with zipfile.ZipFile(path) as archive:
        found = entries(archive.read(PATH))
        card = json.loads(archive.read("documentation/card.json"))
    told = {k.removeprefix("diagnosis."): v for k, v in found.items() if k.startswith("diagnosis.")}
    digest = hashlib.sha256((tmp_path / "answer.json").read_bytes()).hexdigest()
    assert told == {
        "verdict": "explained",
        "sentence": "Thermal softening is missing <from> the model",
        "effects": "thermal_softening",
        "confusion_set": "thermal_softening hersey",
        "confidence": "0.75",
        "model": "constant",
        "synthetic": "true",
        "file_sha256": digest,
    }
    assert card["diagnosis"]["verdict"] == "explained"
    (round_,) = better.error_history_  # type: ignore[attr-defined]
    assert found["refinement.1.added"] == "thermal_softening"
    assert found["refinement.1.judged_by"] == round_["judged_by"]
    for side in ("before", "after"):
        assert float(found[f"refinement.1.{side}.rmse"]) == pytest.approx(round_[side]["rmse"], rel=1e-5)
    about = diagnose(points, model="constant", catalogue=["thermal_softening"]).to_dict()
    (tmp_path / "answer.json").write_text(json.dumps(about))
    packed = with_diagnosis(read_source(better), tmp_path / "answer.json")
    assert packed.card["diagnosis"]["trained_on"] == 8 and packed.note == ""  # type: ignore[index]
    elsewhere = {**about, "model": "linear", "tests": dict.fromkeys(about["tests"], "0")}  # type: ignore[call-overload]
    (tmp_path / "answer.json").write_text(json.dumps(elsewhere))
    packed = with_diagnosis(read_source(better), tmp_path / "answer.json")
    assert packed.card["diagnosis"]["trained_on"] == 0  # type: ignore[index]
    assert "about 8 tests, and the model was trained on none of them" in packed.note
    assert "about the model linear, and the one that is packed is constant+thermal_softening" in packed.note
    (tmp_path / "answer.json").write_text(json.dumps({"verdict": "fine"}))
    with pytest.raises(InputError, match=r"answer\.json: no diagnosis; allowed: a file that diagnose --json"):
        pack(better, tmp_path / "other.fmu", target="python", diagnosis=tmp_path / "answer.json")
