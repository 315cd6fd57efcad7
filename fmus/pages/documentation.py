"""The model card as HTML inside the FMU: documentation/index.html."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from typing import Any

_STYLE = """
:root{--ink:#1b2530;--soft:#566474;--line:#dfe5ea;--wash:#f4f7f9;--paper:#fff;--accent:#0a6f6a;--mid:#4aa6a0;
--light:#a9d5d1;--note:#7a5900;--notewash:#fff6dc}
@media (prefers-color-scheme:dark){:root{--ink:#e4eaf0;--soft:#9fb0c0;--line:#2c3945;--wash:#1a242d;--paper:#11181f;
--accent:#63d2ca;--mid:#3c9d96;--light:#2b625e;--note:#f0d27a;--notewash:#3a3115}}
*{box-sizing:border-box}
body{font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans","DejaVu Sans",sans-serif;color:var(--ink);
background:var(--paper);font-variant-numeric:tabular-nums;max-width:68rem;margin:0 auto;padding:2.4rem 1.5rem 4rem}
a{color:var(--accent)}
h1{font-size:1.9rem;line-height:1.2;margin:0 0 .3em;letter-spacing:-.01em}
h2{font-size:1.2rem;margin:2.4em 0 .4em}
p,li{max-width:48em}p{margin:.5em 0}.soft,figcaption{color:var(--soft)}figcaption{font-size:.9rem;max-width:52em}
.scroll{overflow-x:auto}figure{margin:.8em 0}
table{border-collapse:collapse;margin:.6em 0;font-size:.93rem}
td,th{border-bottom:1px solid var(--line);padding:.35em 1.1em .35em 0;text-align:left;vertical-align:top}
thead th{color:var(--soft);font-weight:600}tbody th{font-weight:600}
td.n,th.n{text-align:right;white-space:nowrap}
code,pre{font:0.93em/1.5 ui-monospace,"DejaVu Sans Mono",Menlo,Consolas,monospace;background:var(--wash);
border-radius:4px;padding:.08em .3em}td code{white-space:nowrap}
pre{padding:.8em 1em;overflow-x:auto;white-space:pre-wrap}
.badge{display:inline-block;background:var(--notewash);color:var(--note);border-radius:99px;padding:.05em .8em;
font-size:.85rem;font-weight:600}
details{margin:.6em 0}summary{cursor:pointer;color:var(--accent)}
svg.curves{width:100%;min-width:760px;height:auto;display:block;font-size:12px}
svg.curves text{fill:var(--soft)}svg.curves .t{fill:var(--ink);font-weight:600}svg.curves .n,svg.curves .e{text-anchor:end}
svg.curves .in{fill:var(--wash)}svg.curves .out{fill:var(--line)}svg.curves .grid{stroke:var(--line);stroke-width:1}
svg.curves polyline{fill:none;stroke-width:2}svg.curves .c0{stroke:var(--light)}svg.curves .c1{stroke:var(--mid)}
svg.curves .c2{stroke:var(--accent)}
@media print{body{max-width:none}}
"""
_PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">
<title>{title}</title><style>{style}</style></head>
<body><h1>{title}</h1>{body}</body></html>
"""


def cell(value: Any) -> str:
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
    return _PAGE.format(title=escape(title), style=_STYLE.replace("\n", ""), body=body).encode()


def page(title: str, sections: Mapping[str, Any]) -> bytes:
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
