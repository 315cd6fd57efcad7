"""Print all laws with their right names: ``python -m benchmarks.literature.listing``."""

from __future__ import annotations

from .names import name
from .registry import REGISTER


def text() -> str:
    """One line a law: key, equation, right names, twins, source."""
    rows = []
    for law in REGISTER.values():
        right = ", ".join(name(k) for k in law.accept) or "outside the catalogue"
        twins = f" [twins: {', '.join(name(k) for k in law.twins)}]" if law.twins else ""
        rows.append(f"{law.key}: {law.equation}\n    -> {right}{twins}\n    {law.source}")
    return "\n".join(rows)


if __name__ == "__main__":
    print(text())
