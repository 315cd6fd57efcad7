"""Reports read back: what a page holds comes back whole, and what it should not hold is gone."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from friction_models.common import InputError
from friction_models.common.markup import paragraph, table
from orchestrator.report.parts.chart import Chart
from orchestrator.report.parts.page import Page
from orchestrator.report.reading import ReadFigure, ReadPage, read_page

BAD = "<img src=x onerror=alert(1)> & 'T'"


def page() -> Page:
    chart = Chart(columns=2, titles=["<b>one</b>", "two"])
    chart.scatter(0, np.array([0.0, 1.0]), np.array([0.1, 0.2]), BAD, "%{y}")
    made = Page(BAD, kicker="test", lead=f"before {paragraph('a < b')}", synthetic=True)
    made.plot(
        "errors",
        BAD,
        chart.dress(222, x="sd"),
        "mu &lt; 0.1",
        BAD,
        table([BAD, "n"], [(BAD, 1)], numeric=[1]),
    )
    made.add("words", "Words", paragraph(BAD), "<ul><li>open <strong>never closed")
    made.add("last", "Last", paragraph("end"))
    return made


def read(text: str, place: Path) -> ReadPage:
    file = place / "page.html"
    file.write_text(text, encoding="utf-8")
    return read_page(file)


class Elements(HTMLParser):
    """Collects elements, attributes and texts as a browser sees them."""

    def __init__(self, html: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[str] = []
        self.ended: list[str] = []
        self.attributes: set[str] = set()
        self.text = ""
        self.feed(html)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes |= {name for name, _ in attrs}

    def handle_endtag(self, tag: str) -> None:
        self.ended.append(tag)

    def handle_data(self, data: str) -> None:
        self.text += data


def test_a_page_comes_back_whole(tmp_path: Path) -> None:
    found = read(page().render(), tmp_path)
    assert found.title == BAD and found.synthetic
    assert [(s.anchor, s.heading) for s in found.sections] == [
        ("errors", BAD),
        ("words", "Words"),
        ("last", "Last"),
    ]
    figure, rows = found.sections[0].parts
    assert isinstance(figure, ReadFigure) and isinstance(rows, str)
    assert (figure.description, figure.caption) == (BAD, "mu &lt; 0.1")
    assert figure.layout["height"] == 222
    assert [trace["name"] for trace in figure.data] == [BAD]
    assert figure.data[0]["x"] == {"dtype": "f8", "bdata": "AAAAAAAAAAAAAAAAAADwPw=="}
    assert found.sections[0].figure() is figure and found.sections[1].figure() is None
    assert Elements(rows).text.replace("\n", "") == f"{BAD}n{BAD}1"


def test_texts_stay_texts_and_all_is_closed(tmp_path: Path) -> None:
    found = read(page().render(), tmp_path)
    html = "".join(p for s in found.sections for p in s.parts if isinstance(p, str))
    seen = Elements(html)
    assert seen.text.count(BAD) == 3
    assert sorted(seen.tags) == sorted(seen.ended)
    assert found.sections[2].parts == ["<p>end</p>"]


@pytest.mark.parametrize(
    "bad",
    [
        BAD,
        "<script>alert(1)</script>",
        "<svg><script>alert(1)</script></svg>",
        '<p onclick="alert(1)" style="position:fixed" id="content">x</p>',
        '<a href="javascript:alert(1)">x</a>',
        "<iframe srcdoc='<script>alert(1)</script>'></iframe>",
        "<form action=//evil.example><input name=password></form>",
        "<style>@import url(//evil.example)</style>",
        "<math><mi xlink:href='data:x,<script>alert(1)</script>'>",
        "<!--<p>--><template><p onclick=alert(1)></template>",
        "<p class='\"><script>alert(1)</script>'>x",
        "</section></main></div></div><section id=a onload=alert(1)>",
        "<scr<script>ipt>alert(1)</script>",
    ],
)
def test_nothing_that_acts_comes_back(tmp_path: Path, bad: str) -> None:
    text = page().render()
    for place in ('<p class="lead">', '<h2 id="words-h">', "<figcaption>", '<section id="last"', "<td "):
        assert place in text
        found = read(text.replace(place, f"{bad}{place}{bad if place.endswith('>') else ''}"), tmp_path)
        html = [found.lead, *(p for s in found.sections for p in s.parts if isinstance(p, str))]
        html += [p.caption for s in found.sections for p in s.parts if isinstance(p, ReadFigure)]
        for part in html:
            seen = Elements(part)
            assert not {"script", "img", "svg", "a", "iframe", "form", "input", "style", "math"} & {
                *seen.tags
            }
            assert seen.attributes <= {"class", "scope"}


@pytest.mark.parametrize(
    "call",
    [
        "",
        "Plotly.newPlot(",
        'Plotly.newPlot("a", {}, {})',
        'Plotly.newPlot("a", [' + "[" * 5000,
        "Plotly.newPlot(1,[],{})",
    ],
)
def test_a_figure_that_is_none_is_left_out(tmp_path: Path, call: str) -> None:
    text = page().render().replace("Plotly.newPlot(", f"{call};void(", 1) if call else page().render()
    figures = [p for s in read(text, tmp_path).sections for p in s.parts if isinstance(p, ReadFigure)]
    assert len(figures) == (0 if call else 1)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b"<html>some page</html>", b"<" * 100_000])
def test_what_is_no_page_is_a_sentence(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "page.html"
    file.write_bytes(content)
    with pytest.raises(InputError, match=r"page\.html"):
        read_page(file)
