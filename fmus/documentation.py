"""The model card as a page inside the FMU: documentation/index.html."""

from __future__ import annotations

import json
from html import escape
from typing import Any

_PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<style>body{{font:16px/1.5 system-ui,sans-serif;max-width:50em;margin:2em auto;padding:0 1em;color:#222}}
table{{border-collapse:collapse;margin:.3em 0}}td,th{{border:1px solid #ccc;padding:.2em .6em;text-align:left;vertical-align:top}}
th{{background:#f4f4f4;font-weight:600}}code{{background:#f4f4f4}}</style></head>
<body><h1>{title}</h1>{body}</body></html>
"""


def _cell(value: Any) -> str:
    if isinstance(value, dict):
        rows = "".join(f"<tr><th>{escape(str(k))}</th><td>{_cell(v)}</td></tr>" for k, v in value.items())
        return f"<table>{rows}</table>"
    if isinstance(value, list | tuple):
        if all(not isinstance(v, dict | list | tuple) for v in value):
            return escape(", ".join(str(v) for v in value))
        return "<br>".join(_cell(v) for v in value)
    return escape(str(value))


def page(title: str, sections: dict[str, Any]) -> bytes:
    """Return a self-contained HTML page with one section an entry; empty entries are left out."""
    body = "".join(
        f"<h2>{escape(name)}</h2>{_cell(content)}" for name, content in sections.items() if content
    )
    return _PAGE.format(title=escape(title), body=body).encode()


def card_json(card: dict[str, Any]) -> bytes:
    """Return the card as JSON."""
    return (json.dumps(card, indent=2, sort_keys=True) + "\n").encode()
