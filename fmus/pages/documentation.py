"""The model card as HTML inside the FMU: documentation/index.html."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from pathlib import Path

ASSETS = Path(__file__).parent / "assets"
_PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">
<title>{title}</title><style>{style}</style></head>
<body><h1>{title}</h1>{body}</body></html>
"""


def cell(value: object) -> str:
    """Return any value of a card as HTML: a mapping as a table, a list as text, the rest as it is.

    Examples
    --------
    >>> cell({"family": "constant", "lubricants": ["A", "<B>"]})
    '<table><tbody><tr><th>family</th><td>constant</td></tr><tr><th>lubricants</th><td>A, &lt;B&gt;</td></tr></tbody></table>'
    """
    if isinstance(value, dict):
        rows = "".join(f"<tr><th>{escape(str(k))}</th><td>{cell(v)}</td></tr>" for k, v in value.items())
        return f"<table><tbody>{rows}</tbody></table>"
    if isinstance(value, list | tuple):
        if all(not isinstance(v, dict | list | tuple) for v in value):
            return escape(", ".join(str(v) for v in value))
        return "".join(f"<div>{cell(v)}</div>" for v in value)
    return escape(str(value))


def html(title: str, body: str) -> bytes:
    """Return a self-contained HTML page, readable without a network, in light and dark.

    Examples
    --------
    >>> html("A law", "<p>mu = 0.1</p>").startswith(b"<!DOCTYPE html>")
    True
    """
    style = (ASSETS / "page.css").read_text(encoding="utf-8").replace("\n", "")
    return _PAGE.format(title=escape(title), style=style, body=body).encode()


def page(title: str, sections: Mapping[str, object]) -> bytes:
    """Return a page with one section an entry; empty entries are left out.

    Examples
    --------
    >>> text = page("A law", {"Formula": "mu = 0.1", "Training data": {}})
    >>> b"mu = 0.1" in text, b"Training data" in text
    (True, False)
    """
    body = "".join(
        f'<h2>{escape(name)}</h2><div class="scroll">{cell(content)}</div>'
        for name, content in sections.items()
        if content
    )
    return html(title, body)


def card_json(card: dict[str, object]) -> bytes:
    """Return the card as JSON.

    Examples
    --------
    >>> print(card_json({"family": "constant"}).decode())
    {
      "family": "constant"
    }
    """
    return (json.dumps(card, indent=2, sort_keys=True) + "\n").encode()
