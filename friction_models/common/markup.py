"""Small pieces of HTML for every page: document, table, paragraph, list. Everything that comes from files is escaped."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence

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


def document(title: str, head: str, body: str) -> str:
    """Return a whole HTML page; `head` (styles, scripts) and `body` are HTML.

    Examples
    --------
    >>> document("A run", "", "<p>done</p>").splitlines()[5]
    '<title>A run - tribofmu</title>'
    """
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)} - tribofmu</title>
{head}</head>
<body>
{body}
</body>
</html>
"""


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

    def cell(k: int, text: object, tag: str, scope: str = "") -> str:
        number = ' class="n"' if k in right else ""
        return f"<{tag}{scope}{number}>{escape(text)}</{tag}>"

    lines = []
    for number, row in enumerate(rows):
        kind = f' class="{classes[number]}"' if classes and classes[number] else ""
        first = f'<th scope="row">{escape(row[0])}</th>'
        lines.append(f"<tr{kind}>{first}{''.join(cell(k, v, 'td') for k, v in enumerate(row[1:], 1))}</tr>")
    head = "".join(cell(k, text, "th", ' scope="col"') for k, text in enumerate(headings))
    above = f"<caption>{escape(caption)}</caption>" if caption else ""
    above += f"<thead><tr>{head}</tr></thead>" if head else ""
    size = ' class="narrow"' if narrow else ' class="wide"' if len(headings) >= WIDE else ""
    return f'<div class="scroll"><table{size}>{above}<tbody>{"".join(lines)}</tbody></table></div>'


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
