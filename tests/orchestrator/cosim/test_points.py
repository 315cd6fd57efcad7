"""A scalar friction FMU in a system with many contact points runs once a point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fmus import pack, pack_forming
from friction_models import LinearFriction, effects
from friction_models.common import InputError
from orchestrator import Master, System
from tests.friction_models.made_up import campaign

LOADS = ("v_rel", "T", "sigma_n", "sd", "psi")
POINTS, STEPS = 30, 8


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return FMUs of one model with memory, for one point and for all, and the forming process."""
    folder = tmp_path_factory.mktemp("points")
    points = campaign(tests=6, points=20)
    model = (LinearFriction() + effects.WorkExhaustion(W_c=0.05, n=1.0)).fit_frame(points)
    return {
        "one": pack(model, folder / "one.fmu"),
        "all": pack(model, folder / "all.fmu", nodes=POINTS),
        "forming": pack_forming(folder / "forming.fmu", n_points=POINTS, mesh_size=0.8),
    }


def system(friction: Path, forming: Path, connections: list[str] | None = None) -> System:
    return System.from_dict(
        {
            "name": "points",
            "communication_step": 0.02,
            "stop_time": 0.02 * STEPS,
            "components": {"friction": {"fmu": str(friction)}, "forming": {"fmu": str(forming)}},
            "connections": connections
            or ["friction.mu -> forming.mu", *(f"forming.{n} -> friction.{n}" for n in LOADS)],
            "record": ["forming.force", "forming.sigma_n", "friction.mu", "friction.in_domain"],
        }
    )


@pytest.mark.parametrize("mode", ["gauss_seidel", "iterated"])
def test_one_instance_a_point_equals_one_fmu_with_all_points(
    fmu: dict[str, Path], tmp_path: Path, mode: str
) -> None:
    runs = [
        Master(system(fmu[which], fmu["forming"]), mode).run(tmp_path / which) for which in ("one", "all")
    ]
    assert runs[0].manifest["components"]["friction"]["instances"] == POINTS
    assert runs[1].manifest["components"]["friction"]["instances"] == 1
    assert runs[0]["friction.mu"].shape == (STEPS + 1, POINTS)
    assert np.ptp(runs[0]["friction.mu"][-1]) > 1e-6, "points in and out of contact must differ"
    np.testing.assert_allclose(runs[0]["friction.mu"], runs[1]["friction.mu"], rtol=1e-12)
    np.testing.assert_allclose(runs[0]["forming.force"], runs[1]["forming.force"], rtol=1e-12)


def test_a_load_that_is_not_connected_is_still_named(fmu: dict[str, Path]) -> None:
    connections = ["friction.mu -> forming.mu", *(f"forming.{n} -> friction.{n}" for n in LOADS[:4])]
    with pytest.raises(InputError, match=r"friction\.psi is not connected.*'forming\.psi -> friction\.psi'"):
        Master(system(fmu["one"], fmu["forming"], connections))
