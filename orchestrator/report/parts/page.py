"""The page around the sections: head, contents, style and the plotting library, embedded once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from typing import TypedDict

from friction_models.common.markup import document, escape

from ...jobs.versions import versions
from .chart import Chart, figure

#: Where the numbers of a page come from that holds no measurement.
VIRTUAL = "Every measurement in this report is synthetic: made by the virtual laboratory, not measured."


class StudyManifest(TypedDict):
    """What pages show of the ``manifest.json`` of a study."""

    versions: dict[str, str]
    sources: dict[str, str]
    jobs: dict[str, object]
    failed: list[str]


@dataclass
class Page:
    """A report under construction.

    Examples
    --------
    >>> page = Page("The model was right", kicker="comparison", synthetic=True)
    >>> page.add("errors", "Errors", "<p>none</p>")
    >>> html = page.render()
    >>> '<a href="#errors">Errors</a>' in html, "synthetic data</span>" in html
    (True, True)
    """

    #: The headline: the verdict, or what the page is about.
    title: str
    #: Small line above the headline.
    kicker: str
    #: HTML of the paragraph below it.
    lead: str = ""
    #: Whether the badge "synthetic data" is shown.
    synthetic: bool = False
    sections: list[tuple[str, str, str]] = field(default_factory=list)

    def add(self, anchor: str, heading: str, *parts: str) -> None:
        """Append a section; parts are HTML."""
        self.sections.append((anchor, heading, "\n".join(p for p in parts if p)))

    def plot(
        self, anchor: str, heading: str, chart: Chart, caption: str, description: str, *parts: str
    ) -> None:
        """Append a section that begins with a chart; see `figure`."""
        self.add(anchor, heading, figure(anchor, chart, caption, description), *parts)

    def render(self, footer: str | None = None) -> str:
        """Return the whole document as one HTML text without any reference to the network; the footer says the version."""
        from plotly.offline import get_plotlyjs

        # The words of a page are there at once: its library of 4.6 MB, which browsers take a second or two to read, waits until
        # they were drawn (later.js).
        style, later = ((files(__package__) / name).read_text("utf-8") for name in ("style.css", "later.js"))
        badge = ' <span class="badge">synthetic data</span>' if self.synthetic else ""
        links = " ".join(f'<a href="#{a}">{escape(h)}</a>' for a, h, _ in self.sections)
        sections = "\n".join(
            f'<section id="{a}" aria-labelledby="{a}-h"><h2 id="{a}-h">{escape(h)}</h2>\n{content}\n</section>'
            for a, h, content in self.sections
        )
        return document(
            self.title,
            f'<style>\n{style}</style>\n<script type="text/plain" id="library">{get_plotlyjs()}</script>\n<script>\n{later}</script>\n',
            f"""<a class="skip" href="#content">Skip to the content</a>
<header class="top">
<p class="kicker">{escape(self.kicker)}{badge}</p>
<h1>{escape(self.title)}</h1>
<p class="lead">{self.lead}</p>
<nav class="contents" aria-label="Contents">{links}</nav>
</header>
<main id="content">
{sections}
</main>
<footer>{f"tribofmu {escape(versions()['tribofmu'])}" if footer is None else footer}</footer>""",
        )


def footer(origin: str, used: Mapping[str, str] | None = None) -> str:
    """Return the foot of a page: versions that were used (by default those at hand), and where the measurements come from.

    Examples
    --------
    >>> footer("Measured in the laboratory.", {"tribofmu": "0.1.0", "python": "3.11.9"})
    'tribofmu 0.1.0, Python 3.11.9. Measured in the laboratory.'
    """
    used = used or versions()
    return f"tribofmu {escape(used['tribofmu'])}, Python {escape(used['python'])}. {escape(origin)}"
