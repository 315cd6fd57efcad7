"""What an FMU shows besides its numbers: icon, terminal of the friction port, licence."""

from __future__ import annotations

from .source import FrictionSource

#: One line for the attribute `license` of the model description.
LICENCE = "wrapper: MIT; the model in it belongs to its author (documentation/licenses)"


def presentation_files(source: FrictionSource, fmi: str) -> dict[str, bytes]:
    """Return icon, terminals and licence by their path in the archive."""
    return {}
