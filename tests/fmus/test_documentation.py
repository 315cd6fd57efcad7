"""The page inside a friction FMU: complete, self-contained, harmless whatever the card holds."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lxml import etree, html

from fmus.interface.friction_source import FrictionSource
from fmus.pages.friction_page import friction_documents
from fmus.pages.response_curves import response_curves
from fmus.source.reading import read_source
from friction_models.loads import LOADS
from tests.fmus.graphs import BOX, runtime

LIBRARIES = {"binaries/linux64/m.so": bytes(12_345), "binaries/darwin64/m.dylib": bytes(2000)}


@pytest.fixture(params=["linear", "memory"])
def source(request: pytest.FixtureRequest, linear_onnx: Path, memory_onnx: Path) -> FrictionSource:
    return read_source({"linear": linear_onnx, "memory": memory_onnx}[request.param])


def page_of(
    source: FrictionSource, nodes: int = 1, fmi: str = "2.0", target: str = "native", arrays: bool = False
) -> str:
    files = friction_documents(source, source.interface(nodes, arrays=arrays), LIBRARIES, target, fmi)
    return files["documentation/index.html"].decode()


@pytest.mark.parametrize(("fmi", "arrays"), [("2.0", False), ("3.0", False), ("3.0", True)])
def test_the_page_tells_what_a_user_needs(fmi: str, arrays: bool, source: FrictionSource) -> None:
    text = page_of(source, fmi=fmi, arrays=arrays)
    root = html.fromstring(text)
    plain = " ".join(root.text_content().split())
    for words in (
        "mu over each load",
        "In a simulator",
        "Platforms",
        "Linux, x86-64",
        "macOS, x86-64 and ARM 64",
        "12 kB",
    ):
        assert words in plain
    rows = [[" ".join(c.text_content().split()) for c in row] for row in root.iter("tr")]
    size = "[n]" if arrays else ""
    for q in LOADS:
        row = next(r for r in rows if r[0] == q.name + size)
        assert row[1:3] == ["input", q.unit]
        assert row[4] == " to ".join(f"{x:.6g}" for x in BOX[q.name])
    names = {r[0] for r in rows}
    assert {f"mu{size}", f"domain_distance{size}", "in_domain", "clamp_to_domain"} <= names
    assert ("n" in names) == arrays
    if source.states:
        assert {f"work{size}", "Ra"} <= names
        assert "The model remembers (work)" in plain


def test_the_page_needs_no_network_and_is_the_same_again(source: FrictionSource) -> None:
    text = page_of(source)
    assert not re.search(r"<script|https?:|url\(|@import|<link|<img", text)
    assert text == page_of(source)
    assert len(text) < 100_000


def test_the_curves_are_those_of_the_model(linear_onnx: Path) -> None:
    """Each curve ends where the model says, in the units of the axis."""
    source = read_source(linear_onnx)
    picture = etree.fromstring(response_curves(source, source.interface(1)))
    lines = picture.findall("polyline")
    assert len(lines) == 3 * len(LOADS)
    ticks = {float(t.text): float(t.get("y")) - 4.0 for t in picture.findall("text[@class='n']")}
    (a, b) = sorted(ticks)[0], sorted(ticks)[-1]
    middle = {n: 0.5 * (lo + hi) for n, (lo, hi) in BOX.items()}
    for line, share in zip(lines[3:6], (0.1, 0.5, 0.9), strict=True):  # over T
        ends = [line.get("points").split()[k].split(",")[1] for k in (0, -1)]
        lower, upper = BOX["sigma_n"]
        for y, temperature in zip(ends, BOX["T"], strict=True):
            loads = middle | {"T": temperature, "sigma_n": lower + share * (upper - lower)}
            mu = runtime(linear_onnx.read_bytes(), np.array([[loads[q.name] for q in LOADS]]))[0]
            expected = ticks[a] + (mu - a) / (b - a) * (ticks[b] - ticks[a])
            assert float(y) == pytest.approx(expected, abs=0.2)


def test_a_model_that_remembers_is_drawn_after_it_slid(memory_onnx: Path) -> None:
    """The state of this one is 1 + sd / 100 mm: over sd its friction rises, over the other loads it is that of 30 mm."""
    source = read_source(memory_onnx)
    picture = etree.fromstring(response_curves(source, source.interface(1)))
    lines = picture.findall("polyline")
    ticks = {float(t.text): float(t.get("y")) - 4.0 for t in picture.findall("text[@class='n']")}
    (a, b) = sorted(ticks)[0], sorted(ticks)[-1]
    at_start = 0.05 + 0.01 + 0.1 * source.system[0].start

    def height(distance: float) -> float:
        mu = at_start + 1e-4 * distance
        return ticks[a] + (mu - a) / (b - a) * (ticks[b] - ticks[a])

    ends = [[float(line.get("points").split()[k].split(",")[1]) for k in (0, -1)] for line in lines]
    lower, upper = source.interface(1).domain.get("sd", (0.0, 60.0))
    reach = upper + 0.12 * (upper - lower)
    for name, found in zip([q.name for q in LOADS for _ in range(3)], ends, strict=True):
        wanted = [height(0.0), height(reach)] if name == "sd" else [height(0.5 * (lower + upper))] * 2
        assert found == pytest.approx(wanted, abs=0.15), name
    said = " ".join(html.fromstring(page_of(source)).text_content().split())
    assert f"after it slid {0.5 * (lower + upper):g} mm (sd) from fresh contact" in said


def test_what_others_write_into_a_card_stays_text(linear_onnx: Path) -> None:
    evil = "<script>alert(1)</script>"
    source = replace(
        read_source(linear_onnx),
        name=evil,
        family=evil,
        formula=evil,
        card={
            evil: {evil: [evil, {evil: evil}]},
            "errors": {evil: {evil: evil}},
            "licence": evil,
            "data": evil,
        },
    )
    text = page_of(source)
    assert "<script" not in text
    assert "&lt;script&gt;" in text


def test_without_curves_and_without_a_domain(linear_onnx: Path) -> None:
    source = replace(read_source(linear_onnx), domain={}, card={})
    text = page_of(source, target="python")
    assert "No trained domain is recorded" in text
    assert "not recorded" in text
    assert "Model card" not in text
    assert "<svg" not in page_of(replace(source, onnx=b""))
