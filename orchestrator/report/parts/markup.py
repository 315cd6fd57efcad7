"""Small pieces of HTML: tables, cards, numbers. Everything that comes from files is escaped."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

#: Tables of this many columns are set smaller, with headings of several lines, so that they fit the page.
WIDE = 8


def escape(text: object) -> str:
    """Return `text` safe for HTML content and attributes.

    Examples
    --------
    >>> escape("<mu> & 'T'")
    '&lt;mu&gt; &amp; &#x27;T&#x27;'
    """
    return html.escape(str(text), quote=True)


def table(
    headings: Sequence[str],
    rows: Iterable[Sequence[object]],
    numeric: Iterable[int] = (),
    classes: Sequence[str] | None = None,
    caption: str = "",
    narrow: bool = False,
) -> str:
    """Return a table; the first cell of a row is its heading, columns in `numeric` align right.

    Examples
    --------
    >>> html = table(["model", "error"], [["a < b", "0.01"]], numeric=[1])
    >>> "a &lt; b" in html, 'class="n"' in html
    (True, True)
    """
    right = set(numeric)
    head = "".join(
        f'<th scope="col"{_number(k in right)}>{escape(text)}</th>' for k, text in enumerate(headings)
    )
    lines = []
    for number, row in enumerate(rows):
        kind = f' class="{classes[number]}"' if classes and classes[number] else ""
        cells = "".join(
            f'<th scope="row">{escape(cell)}</th>'
            if k == 0
            else f"<td{_number(k in right)}>{escape(cell)}</td>"
            for k, cell in enumerate(row)
        )
        lines.append(f"<tr{kind}>{cells}</tr>")
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    kind = ' class="narrow"' if narrow else ' class="wide"' if len(headings) >= WIDE else ""
    return f'<div class="scroll"><table{kind}>{title}<thead><tr>{head}</tr></thead><tbody>{"".join(lines)}</tbody></table></div>'


def _number(right: bool) -> str:
    return ' class="n"' if right else ""


@dataclass(frozen=True)
class Change:
    """A number before and after (None where nothing was changed), with its unit and decimals to show.

    Examples
    --------
    >>> change = Change("error", before=0.020, after=0.015)
    >>> round(change.relative, 6), change.rose, "fell by 25 %" in change.card()
    (-0.25, False, True)
    """

    name: str
    before: float
    after: float | None
    unit: str = ""
    decimals: int = 4

    @property
    def relative(self) -> float:
        """Change relative to the value before; negative where it fell."""
        return (self.after - self.before) / self.before if self.before and self.after is not None else 0.0

    @property
    def rose(self) -> bool:
        """Whether the number is larger than before."""
        return self.after is not None and self.after > self.before

    def card(self) -> str:
        """Return the card that shows it; it also says so when the number rose."""
        unit = f' <span class="unit">{escape(self.unit)}</span>' if self.unit else ""
        head = f'<div class="card"><p class="name">{escape(self.name)}</p><p class="numbers">'
        if self.after is None:
            return head + f"{self.before:.{self.decimals}f}{unit}</p></div>"
        kind = "rose" if self.rose else "fell"
        change = "unchanged" if self.after == self.before else f"{kind} by {abs(100 * self.relative):.0f} %"
        return head + (
            f'<span class="before">{self.before:.{self.decimals}f}</span><span class="arrow" aria-label="then">&rarr;</span>'
            f'<span class="after">{self.after:.{self.decimals}f}</span>{unit}</p>'
            f'<p class="change {kind}">{change}</p></div>'
        )


def cards(changes: Iterable[Change]) -> str:
    """Return the cards side by side.

    Examples
    --------
    >>> cards([Change("error", 0.020, None, decimals=2)])
    '<div class="cards"><div class="card"><p class="name">error</p><p class="numbers">0.02</p></div></div>'
    """
    return f'<div class="cards">{"".join(c.card() for c in changes)}</div>'


def paragraph(text: str, kind: str = "") -> str:
    """Return a paragraph of plain text.

    Examples
    --------
    >>> paragraph("mu < 0.1"), paragraph("synthetic", kind="note")
    ('<p>mu &lt; 0.1</p>', '<p class="note">synthetic</p>')
    """
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def bullets(items: Iterable[str]) -> str:
    """Return a list of plain texts, empty for none.

    Examples
    --------
    >>> bullets(["first", "second"]), bullets([])
    ('<ul class="plain"><li>first</li><li>second</li></ul>', '')
    """
    lines = "".join(f"<li>{escape(item)}</li>" for item in items)
    return f'<ul class="plain">{lines}</ul>' if lines else ""
