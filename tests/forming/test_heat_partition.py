"""Share of the friction heat that a workpiece takes up."""

from __future__ import annotations

import pytest

from forming import Upsetting
from friction_models.common import InputError


@pytest.mark.parametrize("share", [0.0, 0.5, 0.8])
def test_the_workpiece_takes_its_share_of_the_friction_work(share: float) -> None:
    process = Upsetting(mesh_size=1.8, n_points=12, friction_heat_share=share)
    process.start()
    process.set_mu(0.15)
    process.advance(2.0)
    energy, material = process.simulation.state.energy, process.simulation.material
    assert energy.friction > 0.02 * energy.plastic
    released = energy.heat_generated - material.taylor_quinney * energy.plastic
    assert released == pytest.approx(share * energy.friction, rel=0.02, abs=2e-3 * energy.friction)


def test_a_share_lies_between_nothing_and_all() -> None:
    with pytest.raises(InputError, match=r"friction_heat_share = 1\.2 *; allowed: 0 to 1"):
        Upsetting(friction_heat_share=1.2)
