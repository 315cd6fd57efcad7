"""Libraries of FMUs for other machines, run by an emulator or by wine through a small C host."""

from __future__ import annotations

MACHINES: list = []
