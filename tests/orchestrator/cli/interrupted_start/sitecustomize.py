"""Python finds this file first where its folder is in ``PYTHONPATH``: a process interrupts itself in the middle of its imports."""

from __future__ import annotations

import os
import signal
import sys
from importlib.abc import MetaPathFinder

#: Every command needs it.
LATE = "pydantic_core._pydantic_core"


class _Interrupts(MetaPathFinder):
    """Finds nothing."""

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        if name == LATE:
            os.kill(os.getpid(), signal.SIGINT)


sys.meta_path.insert(0, _Interrupts())
