"""Ways to damage tables, YAML, JSON and plain bytes; all of it drawn from a seeded generator."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable
from typing import Any

import yaml

#: What people, spreadsheets and loggers leave in a cell.
CELLS = (
    *("", " ", "nan", "NaN", "inf", "-inf", "1e308", "-1e308", "1e400", "1e-320", "-0.0", "0", "-1", "1e9"),
    *("abc", "1,5", "1.2.3", "0x10", "1_000", "True", "None", "2026-11-22", "=1+1", "#DIV/0!", "'", '"', "ü"),
    *("\u2212" + "1", "\u0661", "1 000", "\x00", "a" * 100_000, "9" * 400),
)
VALUES: tuple[Any, ...] = (
    *(
        None,
        True,
        "",
        "abc",
        0,
        -1,
        1e308,
        10**400,
        math.nan,
        math.inf,
        -math.inf,
        1e-320,
        [],
        {},
        [1, 2],
        {"a": 1},
    ),
    *(
        ["x"] * 1000,
        "../../../secret.txt",
        "/etc/passwd",
        "a" * 100_000,
        "nan",
        "${HOME}",
        [[[[[1]]]]],
        "1 mm/s",
        b"x",
    ),
)
Damage = Callable[[random.Random, bytes], bytes]


def flip(draw: random.Random, content: bytes) -> bytes:
    """Flip some bits."""
    changed = bytearray(content)
    for _ in range(draw.choice((1, 1, 2, 8, 64)) if changed else 0):
        changed[draw.randrange(len(changed))] ^= 1 << draw.randrange(8)
    return bytes(changed)


def cut(draw: random.Random, content: bytes) -> bytes:
    """Cut the end, the beginning or the middle out."""
    a, b = sorted(draw.randrange(len(content) + 1) for _ in range(2))
    return draw.choice((content[:a], content[a:], content[:a] + content[b:]))


def insert(draw: random.Random, content: bytes) -> bytes:
    """Insert random bytes, zeros, or a piece of the file."""
    at = draw.randrange(len(content) + 1)
    piece = draw.choice(
        (draw.randbytes(20), bytes(300), content[: draw.randrange(len(content) + 1)], b"\r\r\n")
    )
    return content[:at] + piece + content[at:]


def replace_all(draw: random.Random, content: bytes) -> bytes:
    """Something else altogether."""
    others = (
        b"",
        b"\n",
        bytes(1000),
        draw.randbytes(500),
        b"PK\x03\x04",
        b"\x1f\x8b\x08\x00",
        b"CDF\x01",
        b"PAR1PAR1",
    )
    return draw.choice((*others, b"\x89HDF\r\n\x1a\n", b"[" * 50_000, b"{" * 50_000, b"{}", b"[]", b"null"))


def encoding(draw: random.Random, content: bytes) -> bytes:
    """Another encoding or other ends of lines."""
    text = content.decode("utf-8", "replace")
    kind = draw.choice(
        ("utf-8-sig", "utf-16", "utf-16-le", "utf-32", "latin-1", "cr", "crlf", "nul", "utf-7", "bom twice")
    )
    match kind:
        case "cr" | "crlf":
            return text.replace("\n", "\r" if kind == "cr" else "\r\n").encode()
        case "nul":
            return text.replace("\n", "\x00\n", draw.choice((1, -1))).encode()
        case "latin-1":
            return text.replace("t", "\xe4", 3).encode("latin-1", "replace")
        case "bom twice":
            return b"\xef\xbb\xbf" * 2 + content
    return text.encode(kind)


BYTES: tuple[Damage, ...] = (flip, flip, cut, insert, replace_all)


def table(draw: random.Random, content: bytes) -> bytes:
    """Change columns, rows and cells of a CSV file."""
    rows = [line.split(",") for line in content.decode("utf-8", "replace").splitlines()]
    for _ in range(draw.choice((1, 1, 1, 2, 4))):
        if rows and rows[0]:
            draw.choice(_TABLE)(draw, rows)
    mark = draw.choice((",", ",", ",", ",", ";", "\t", "|", " , "))
    return "\n".join(mark.join(row) for row in rows).encode("utf-8", "replace")


def _cell(draw: random.Random, rows: list[list[str]]) -> None:
    row = draw.choice(rows[1:] or rows)
    if row:
        row[draw.randrange(len(row))] = draw.choice(CELLS)


def _column(draw: random.Random, rows: list[list[str]]) -> None:
    k, value = draw.randrange(len(rows[0])), draw.choice(CELLS[:-2])
    for row in rows[1:]:
        row[k : k + 1] = [value]


def _swap_columns(draw: random.Random, rows: list[list[str]]) -> None:
    a, b = draw.randrange(len(rows[0])), draw.randrange(len(rows[0]))
    rows[0][a], rows[0][b] = rows[0][b], rows[0][a]


def _double_column(draw: random.Random, rows: list[list[str]]) -> None:
    k = draw.randrange(len(rows[0]))
    for row in rows:
        row += row[k : k + 1]


def _drop_column(draw: random.Random, rows: list[list[str]]) -> None:
    k = draw.randrange(len(rows[0]))
    for row in rows:
        del row[k : k + 1]


def _rename(draw: random.Random, rows: list[list[str]]) -> None:
    k = draw.randrange(len(rows[0]))
    name = rows[0][k]
    rows[0][k] = draw.choice(
        (name.upper(), name + " ", f"{name} [m]", f"{name} [furlong]", "", "x" * 5000, "\u202e" + name)
    )


def _drop_rows(draw: random.Random, rows: list[list[str]]) -> None:
    rows[1:] = draw.choice(([], rows[1:2], rows[1:3], draw.sample(rows[1:], len(rows) // 2)))


def _more_rows(draw: random.Random, rows: list[list[str]]) -> None:
    rows.extend(draw.choice((rows[1:], rows[1:2] * 20, [rows[0][:]], [[]], [[""] * len(rows[0])])))


def _ragged(draw: random.Random, rows: list[list[str]]) -> None:
    row = draw.choice(rows)
    if draw.random() < 0.5:
        row += ["1"] * draw.choice((1, 3, 2000))
    else:
        del row[draw.randrange(len(row) + 1) :]


def _shuffle(draw: random.Random, rows: list[list[str]]) -> None:
    body = rows[1:]
    draw.shuffle(body)
    rows[1:] = body


def _scale(draw: random.Random, rows: list[list[str]]) -> None:
    """Another unit: a whole column times a number."""
    k, factor = draw.randrange(len(rows[0])), draw.choice((-1.0, 0.0, 1e-6, 1e3, 1e6, 1e12, 1e300))
    for row in rows[1:]:
        if k < len(row):
            try:
                row[k] = repr(float(row[k]) * factor)
            except ValueError:
                row[k] += "x"


def _quotes(draw: random.Random, rows: list[list[str]]) -> None:
    row = draw.choice(rows)
    if row:
        row[0] = draw.choice(('"' + row[0], '"' + row[0] + '\n"', row[0] + '""'))


_TABLE = (
    *(
        _cell,
        _cell,
        _cell,
        _column,
        _swap_columns,
        _double_column,
        _drop_column,
        _rename,
        _drop_rows,
        _more_rows,
    ),
    *(_ragged, _shuffle, _scale, _quotes),
)


def document(draw: random.Random, content: bytes) -> bytes:
    """Change keys and values of a YAML or JSON file."""
    is_json = content.lstrip()[:1] in (b"{", b"[")
    tree = json.loads(content) if is_json else yaml.safe_load(content)
    for _ in range(draw.choice((1, 1, 2, 4))):
        tree = _changed(draw, tree)
    if is_json:
        return json.dumps(tree, default=str).encode()
    return yaml.safe_dump(tree, sort_keys=False).encode()


def _changed(draw: random.Random, tree: Any) -> Any:
    """Go down to a random place and change it there."""
    if isinstance(tree, dict) and tree and draw.random() < 0.85:
        key = draw.choice(list(tree))
        match draw.randrange(8):
            case 0:
                return {k: v for k, v in tree.items() if k != key}
            case 1:
                new = draw.choice((f"{key}x", str(key).upper(), "", 1, None, "__class__"))
                return {(new if k == key else k): v for k, v in tree.items()}
            case 2:
                return tree | {draw.choice(("extra", "name", "v_rel", "")): draw.choice(VALUES)}
        return {k: (_changed(draw, v) if k == key else v) for k, v in tree.items()}
    if isinstance(tree, list) and tree and draw.random() < 0.85:
        k = draw.randrange(len(tree))
        match draw.randrange(4):
            case 0:
                return tree[:k] + tree[k + 1 :]
            case 1:
                return tree + tree[k : k + 1] * draw.choice((1, 50))
        return [*tree[:k], _changed(draw, tree[k]), *tree[k + 1 :]]
    if isinstance(tree, str) and draw.random() < 0.4:
        return draw.choice(
            (tree + "x", tree.upper(), tree[::-1], tree.replace(".", ""), "../" + tree, tree + "\n" + tree)
        )
    if isinstance(tree, int | float) and draw.random() < 0.4:
        return draw.choice((-tree, tree * 1000, tree % 7, str(tree), f"{tree} mm", [tree]))
    return draw.choice(VALUES)


def nested(draw: random.Random, content: bytes) -> bytes:
    """Very deep, or meant to blow up."""
    depth = draw.choice((50, 900, 20_000))
    lists = ",".join(["*a"] * 9)
    bomb = "a: &a [1,1]\n" + "".join(
        f"{chr(98 + k)}: &{chr(98 + k)} [{lists.replace('a', chr(97 + k))}]\n" for k in range(9)
    )
    return draw.choice(
        (
            content + b"\nextra: " + b"[" * depth + b"]" * depth + b"\n",
            b"[" * depth + b"]" * depth,
            b'{"a":' * depth + b"1" + b"}" * depth,
            bomb.encode(),
            content + b"\n---\n" + content,
            content + b"\n" + content,
        )
    )
