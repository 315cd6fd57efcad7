"""A C function, compiled twice: for processors with AVX2 and FMA, and for any other; the processor decides which one runs.

A long function is written in parts, as the time of compilers grows with the square of its length.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from .emission import Writer
from .tensors import refuse

#: Statements of a part, and up to which a function stays in one piece.
PART, WHOLE = 200, 600
#: Largest arrays of a function on the stack: more than this is not offered.
_STACK_LIMIT = 512 * 1024
#: Plain variables of `emission.Writer`, each defined once.
_SCALAR = re.compile(r"\b[td]\d+\b")


def function(name: str, arguments: str, writer: Writer) -> str:
    """Return a C function with the statements of `writer`, in two builds, and the one that chooses.

    Raises InputError: more values than the stack has room for.
    """
    lines, buffers = writer.lines, writer.buffers
    if len(lines) <= WHOLE:
        _check_stack(buffers.total(), writer.where)
        return chosen(name, arguments, [*buffers.declarations(), *lines])
    parts = [lines[i : i + PART] for i in range(0, len(lines), PART)]
    # What more than one part uses stands in one array: buffers, and the variables that outlive their part.
    places = buffers.offsets()
    total = buffers.total()
    texts: list[str] = []
    calls: list[str] = []
    last = {v: k for k, part in enumerate(parts) for line in part for v in _SCALAR.findall(line)}
    slots: dict[str, int] = {}
    for k, part in enumerate(parts):
        used = dict.fromkeys(v for line in part for v in _SCALAR.findall(line))
        words = {word for line in part for word in re.findall(r"\bb\d+\b", line)}
        head = [f"double *const {b} = w + {at};" for b, at in places.items() if b in words]
        head += [f"const double {v} = w[{slots[v]}];" for v in used if v in slots]
        kept = [v for v in used if v not in slots and last[v] > k]
        for v in kept:
            slots[v] = total
            total += 1
        tail = [f"w[{slots[v]}] = {v};" for v in kept]
        texts.append(_builds(f"{name}_part{k}", f"{arguments}, double *w", ["(void)w;", *head, *part, *tail]))
        calls.append(f"{name}_part{k}")
    _check_stack(total, writer.where)
    names = _names(arguments)
    body = [f"double w[{max(total, 1)}];"]
    body += [f"if (fused) {c}_wide({names}, w); else {c}_plain({names}, w);" for c in calls]
    return "".join(texts) + chosen(name, arguments, body)


def chosen(name: str, arguments: str, lines: Sequence[str]) -> str:
    """Return a function in two builds, and the one that chooses."""
    names = _names(arguments)
    return f"""\
{_builds(name, arguments, lines)}\
TF_UNUSED static void {name}({arguments}) {{
    if (tf_wide()) {name}_wide({names});
    else {name}_plain({names});
}}
"""


def _builds(name: str, arguments: str, lines: Sequence[str]) -> str:
    names = _names(arguments)
    unused = " ".join(f"(void){a};" for a in names.split(", "))
    body = "".join(f"    {line}\n" for line in lines)
    return f"""\
TF_INLINE void {name}_body({arguments}, const int fused) {{
    {unused} (void)fused;
{body}}}
TF_WIDE void {name}_wide({arguments}) {{ {name}_body({names}, 1); }}
TF_APART void {name}_plain({arguments}) {{ {name}_body({names}, 0); }}
"""


def _check_stack(doubles: int, where: str) -> None:
    if 8 * doubles > _STACK_LIMIT:
        raise refuse(where, f"the values of one point need {8 * doubles} bytes, allowed: {_STACK_LIMIT}")


def _names(arguments: str) -> str:
    return ", ".join(a.split()[-1].lstrip("*") for a in arguments.split(", "))
