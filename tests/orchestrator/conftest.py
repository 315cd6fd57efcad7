from __future__ import annotations

from pathlib import Path

import pytest

from tests.orchestrator import tiny_fmus


@pytest.fixture(scope="session")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("tiny")
    return {
        "law": tiny_fmus.law(folder, "TinyLaw"),
        "other_law": tiny_fmus.law(folder, "OtherLaw", offset=0.3, slope=0.2),
        "scalar_law": tiny_fmus.law(folder, "ScalarLaw", n=1),
        "fragile_law": tiny_fmus.law(folder, "FragileLaw", fails_above=1.2),
        "process": tiny_fmus.process(folder, "TinyProcess"),
    }
