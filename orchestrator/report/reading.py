"""Pages read back: the figures, tables and words of a report as data, for whoever shows them elsewhere.

A page is a file, and files may come from anybody. Nothing of its markup is handed on: known elements are written anew,
their text is escaped again, figures are parsed as JSON, and everything else is dropped.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, TypeAlias

from friction_models.common import InputError, check_readable
from friction_models.common.markup import escape

#: Largest page [byte]; each holds the plotting library, 4.6 MB.
LARGEST = 80_000_000
_CALL = "Plotly.newPlot("
_START = '<header class="top">'
#: Elements that are written anew.
_KEPT = {
    *("p", "strong", "em", "code", "pre", "ul", "ol", "li", "h3", "h4", "span", "div", "br", "sub", "sup"),
    *("table", "caption", "thead", "tbody", "tr", "th", "td", "details", "summary"),
}
_EMPTY = {"br"}
#: Elements whose text is no text of the page.
_DROPPED = {"script", "style", "nav", "footer", "template", "svg", "iframe", "object"}
_ATTRIBUTES = {"class", "scope"}


@dataclass(frozen=True)
class ReadFigure:
    """A figure as plotly takes it: ``data`` and ``layout``; `caption` is HTML, `description` plain text."""

    data: list[Any]
    layout: dict[str, Any]
    caption: str
    description: str


#: HTML that was written anew, or a figure.
Part: TypeAlias = "str | ReadFigure"


@dataclass
class ReadSection:
    """A section of a page."""

    anchor: str
    heading: str
    parts: list[Part] = field(default_factory=list)

    def figure(self) -> ReadFigure | None:
        """Return the first figure."""
        return next((p for p in self.parts if isinstance(p, ReadFigure)), None)


@dataclass
class ReadPage:
    """A page that was read back; `title` is plain text, `lead` HTML."""

    title: str = ""
    lead: str = ""
    synthetic: bool = False
    sections: list[ReadSection] = field(default_factory=list)

    def section(self, anchor: str) -> ReadSection | None:
        """Return the section of that anchor."""
        return next((s for s in self.sections if s.anchor == anchor), None)


def read_page(file: Path) -> ReadPage:
    """Return what a report holds.

    Raises InputError: no page that `Page` wrote.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from orchestrator.report.parts.page import Page
    >>> page = Page("The model was right", kicker="comparison")
    >>> page.add("errors", "Errors", "<p>a &lt; b</p><script>alert(1)</script>")
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "page.html"
    ...     _ = file.write_text(page.render(), encoding="utf-8")
    ...     read_page(file).sections[0].parts
    ['<p>a &lt; b</p>']
    """
    check_readable(file, LARGEST, "a page of tribofmu")
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{file}: cannot be read ({error}); allowed: a page of tribofmu") from None
    start = text.find(_START)
    if start < 0:
        raise InputError(f"{file}: no page of tribofmu; allowed: a file that --report wrote")
    reader = _Reader()
    reader.feed(text[start:])
    reader.close()
    reader.flush()
    return reader.page


@dataclass
class _Begun:
    """A figure whose end was not read yet; what is drawn stands in a script of its own."""

    description: str = ""
    caption: str = ""
    drawn: tuple[list[Any], dict[str, Any]] | None = None


class _Reader(HTMLParser):
    """Takes a page apart as it is parsed."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.page = ReadPage()
        self._open: list[str] = []
        self._out: list[str] = []
        self._into: str | None = None  # title, lead, heading, caption, script: where text goes
        self._caught: list[str] = []
        self._dropping = 0
        self._figure: _Begun | None = None

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        kind = given.get("class") or ""
        if tag == "script" and self._figure is not None:
            self._catch("script")
        elif tag in _DROPPED:
            self._dropping += 1
        elif self._dropping or self._into == "script":
            return
        elif tag == "section":
            self.flush()
            self.page.sections.append(ReadSection(given.get("id") or "", ""))
        elif tag == "figure":
            self.flush()
            self._figure = _Begun()
        elif self._figure is not None and tag == "div":
            self._figure.description = self._figure.description or given.get("aria-label") or ""
        elif tag in {"h1", "h2", "figcaption"} or (tag == "p" and kind == "lead"):
            self.flush()
            self._catch({"h1": "title", "h2": "heading", "figcaption": "caption"}.get(tag, "lead"))
        elif tag == "span" and kind == "badge":
            self.page.synthetic = True
            self._dropping += 1
            self._open.append("badge")
        elif tag in _KEPT and not (tag == "p" and kind == "kicker"):
            shown = "".join(f' {k}="{escape(v or "")}"' for k, v in attrs if k in _ATTRIBUTES)
            self._mark(f"<{tag}{shown}>")
            if tag not in _EMPTY:
                self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag == "script" and self._into == "script":
            script = self._caught_text()
            if self._figure is not None:
                self._figure.drawn = _drawn(script)
        elif tag in _DROPPED:
            self._dropping = max(0, self._dropping - 1)
        elif tag == "span" and self._open and self._open[-1] == "badge":
            self._open.pop()
            self._dropping -= 1
        elif self._dropping:
            return
        elif tag == "figure":
            self._close_figure()
        elif self._into is not None and tag in {"h1", "h2", "figcaption", "p"} and not self._open:
            self._put(self._into, self._caught_text())
        elif tag == "section":
            self.flush()
        elif self._open and self._open[-1] == tag:
            self._open.pop()
            self._mark(f"</{tag}>")

    def handle_data(self, data: str) -> None:
        if self._into == "script":
            self._caught.append(data)
        elif not self._dropping:
            self._write(data if self._into in {"title", "heading"} else escape(data))

    def _mark(self, markup: str) -> None:
        if self._into not in {"title", "heading"}:  # which are plain text
            self._write(markup)

    def _write(self, text: str) -> None:
        if self._into is not None:
            self._caught.append(text)
        elif self._figure is None:
            self._out.append(text)

    def _catch(self, what: str) -> None:
        self._into, self._caught = what, []

    def _caught_text(self) -> str:
        text = "".join(self._caught)
        self._into, self._caught = None, []
        return text

    def _put(self, what: str, text: str) -> None:
        if what == "title":
            self.page.title = text
        elif what == "lead":
            self.page.lead = text
        elif what == "heading" and self.page.sections:
            self.page.sections[-1].heading = text
        elif what == "caption" and self._figure is not None:
            self._figure.caption = text

    def _close_figure(self) -> None:
        figure, self._figure = self._figure, None
        if figure is None or figure.drawn is None or not self.page.sections:
            return
        whole = ReadFigure(*figure.drawn, figure.caption, figure.description)
        self.page.sections[-1].parts.append(whole)

    def flush(self) -> None:
        """Close what is open and keep what was written as a part of the section."""
        if self._into is None:
            self._out += [f"</{tag}>" for tag in reversed(self._open) if tag != "badge"]
            self._open = []
        text = "".join(self._out).strip()
        self._out = []
        if text and self.page.sections:
            self.page.sections[-1].parts.append(text)


def _drawn(script: str) -> tuple[list[Any], dict[str, Any]] | None:
    """Return data and layout of the call that draws a chart; None where it is none of ours."""
    at = script.find(_CALL)
    if at < 0:
        return None
    decoder, found = json.JSONDecoder(), []
    at += len(_CALL)
    try:
        for _ in range(3):
            while script[at] in " \n,":
                at += 1
            value, at = decoder.raw_decode(script, at)
            found.append(value)
    except (ValueError, IndexError, RecursionError):
        return None
    name, data, layout = found
    if not (isinstance(name, str) and isinstance(data, list) and isinstance(layout, dict)):
        return None
    return data, layout
