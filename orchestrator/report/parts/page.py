"""The page around the sections: head, contents, style and the plotting library, embedded once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from typing import Any

from ...jobs.versions import versions
from .markup import escape


@dataclass
class Page:
    """A report under construction.

    Attributes
    ----------
    title : str
        The verdict, or what the page is about: the headline.
    kicker : str
        Small line above the headline.
    lead : str
        HTML of the paragraph below it.
    synthetic : bool
        Whether the badge "synthetic data" is shown.

    Examples
    --------
    >>> page = Page("The model was right", kicker="comparison", synthetic=True)
    >>> page.add("errors", "Errors", "<p>none</p>")
    >>> html = page.render()
    >>> '<a href="#errors">Errors</a>' in html, "synthetic data</span>" in html
    (True, True)
    """

    title: str
    kicker: str
    lead: str = ""
    synthetic: bool = False
    sections: list[tuple[str, str, str]] = field(default_factory=list)

    def add(self, anchor: str, heading: str, *parts: str) -> None:
        """Append a section; parts are HTML."""
        self.sections.append((anchor, heading, "\n".join(p for p in parts if p)))

    def render(self, footer: str | None = None) -> str:
        """Return the whole document as one HTML text without any reference to the network; the footer says the version."""
        from plotly.offline import get_plotlyjs

        style = files(__package__).joinpath("style.css").read_text(encoding="utf-8")
        badge = ' <span class="badge">synthetic data</span>' if self.synthetic else ""
        links = " ".join(f'<a href="#{a}">{escape(h)}</a>' for a, h, _ in self.sections)
        body = "\n".join(
            f'<section id="{a}" aria-labelledby="{a}-h"><h2 id="{a}-h">{escape(h)}</h2>\n{content}\n</section>'
            for a, h, content in self.sections
        )
        return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(self.title)} - tribofmu</title>
<style>
{style}</style>
<script>{get_plotlyjs()}</script>
</head>
<body>
<a class="skip" href="#content">Skip to the content</a>
<header class="top">
<p class="kicker">{escape(self.kicker)}{badge}</p>
<h1>{escape(self.title)}</h1>
<p class="lead">{self.lead}</p>
<nav class="contents" aria-label="Contents">{links}</nav>
</header>
<main id="content">
{body}
</main>
<footer>{f"tribofmu {escape(versions()['tribofmu'])}" if footer is None else footer}</footer>
</body>
</html>
"""


def footer(used: Mapping[str, str], origin: str) -> str:
    """Return the foot of a study's page: versions that were used, and where the measurements come from.

    Examples
    --------
    >>> footer({"tribofmu": "0.1.0", "python": "3.11.9"}, "Measured in the laboratory.")
    'tribofmu 0.1.0, Python 3.11.9. Measured in the laboratory.'
    """
    return f"tribofmu {escape(used['tribofmu'])}, Python {escape(used['python'])}. {escape(origin)}"


def figure(name: str, chart: Any, caption: str, description: str) -> str:
    """Return the HTML of a chart with its caption; `description` is what a screen reader says.

    Examples
    --------
    >>> import plotly.graph_objects as go
    >>> html = figure("mu", go.Figure(go.Scatter(x=[0, 1], y=[0.1, 0.1])), "mu over distance", "A level line.")
    >>> 'aria-label="A level line."' in html, "<figcaption>mu over distance</figcaption>" in html
    (True, True)
    """
    html = chart.to_html(
        full_html=False,
        include_plotlyjs=False,
        div_id=f"chart-{name}",
        config={"displayModeBar": False, "responsive": True},
    )
    return (
        f'<figure><div class="plot" role="img" aria-label="{escape(description)}">{html}</div>'
        f"<figcaption>{caption}</figcaption></figure>"
    )
