"""A law that neither an effect of the catalogue nor smooth curves follow, and that a term of the grammar does: it is not the name."""

from __future__ import annotations

import numpy as np
import pandas as pd

from friction_models.discovery import diagnose

SCATTER = 0.03
SPEEDS = np.geomspace(0.1, 100.0, 5)
TEMPERATURES = np.linspace(-10.0, 95.0, 12)


def polymer(seed: int) -> pd.DataFrame:
    """A polymer that slides on steel, mean friction of one test at each speed and temperature: losses peak at the glass transition.

    Debye's peak of the loss, broadened, over the speed that the law of Arrhenius refers to 35 degC; 200 kJ/mol.
    """
    rng = np.random.default_rng(seed)
    rows = []
    for test, (v_rel, T) in enumerate((v, T) for v in SPEEDS for T in TEMPERATURES):
        faster = np.exp(200e3 / 8.314 * (1.0 / (T + 273.15) - 1.0 / 308.15))
        ratio = (v_rel * faster) ** 0.8
        mu = 0.35 + 0.35 * 2.0 * ratio / (1.0 + ratio**2)
        rows.append({"test_id": f"t{test:02d}", "v_rel": v_rel, "T": T, "mu": mu + rng.normal(0.0, SCATTER)})
    return pd.DataFrame(rows)


def test_a_peak_that_moves_with_another_load_has_no_name() -> None:
    """Curves of two loads do not follow it, so that a threshold in the temperature seemed to be all that can be predicted."""
    found = [diagnose(polymer(seed)) for seed in range(4)]
    seen = [d for d in found if d.noise_floor["source"] == "terms"]
    assert len(seen) > 2, [d.sentence for d in found]
    for diagnosis in seen:
        assert diagnosis.verdict == "unknown_structure" and not diagnosis.effects
        assert "T" in diagnosis.where[0]["variables"]
        assert "log_v_rel" in diagnosis.formulas[0].name and "T" in diagnosis.formulas[0].name
        # what terms predict of unseen tests is what is missing, and not the scatter of the tests
        assert 0.5 * SCATTER < diagnosis.error_budget["floor"] < diagnosis.error_budget["missing"]


def test_terms_take_no_name_from_a_law_that_is_one() -> None:
    """Friction falls along the speed; that half of the error is scatter leaves terms enough to choose from."""
    rng = np.random.default_rng(3)
    loads = pd.DataFrame([{"v_rel": v, "T": T} for v in SPEEDS for T in TEMPERATURES])
    mu = 0.35 + 0.12 / (1.0 + loads["v_rel"] / 5.0) + 0.0005 * loads["T"] + rng.normal(0.0, 0.025, len(loads))
    found = diagnose(loads.assign(mu=mu, test_id=[f"t{k:02d}" for k in range(len(loads))]))
    assert found.effects == ["stribeck"] and found.verdict in ("explained", "ambiguous"), found.sentence
    assert found.noise_floor["source"] != "terms"
