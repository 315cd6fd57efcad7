from __future__ import annotations

import pytest

from .subjects import Subjects


@pytest.fixture(scope="session")
def subjects(tmp_path_factory: pytest.TempPathFactory) -> Subjects:
    """Return the FMUs that all clients run."""
    return Subjects(tmp_path_factory.mktemp("subjects"))
