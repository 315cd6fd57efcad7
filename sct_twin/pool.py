"""The pool of processes, which forming runs use, too."""

from forming.pool import Progress, map_unordered

__all__ = ["Progress", "map_unordered"]
