"""The verification table: fast cases pass, broken physics fails, what cannot run is visible."""

from __future__ import annotations

import functools
import json
import math
from dataclasses import replace

import pytest

from forming.verification import (
    CASES,
    Case,
    Row,
    Unfinished,
    calculix,
    case,
    extrusion,
    ring,
    ring_closed_form,
    upsetting,
)
from forming.verification.calculix import CalculixError, Compression, input_deck
from forming.verification.table import COLUMNS, cells, markdown_page, summary, text_table
from friction_models.common import InputError
from orchestrator.cli.commands.verifying import chosen
from orchestrator.cli.main import run as command

CCX = pytest.mark.skipif(
    calculix.executable() is None, reason="CalculiX (ccx, Debian package calculix-ccx) is not installed"
)


def row(ours: float = 101.0, **change) -> Row:
    return replace(Row("force", "kN", 100.0, "a book", ours, 2.0, case="one"), **change)


def test_verdicts():
    assert row().deviation == pytest.approx(1.0) and row().verdict == "pass"
    assert row(97.0).verdict == "fail"
    assert row(math.nan).verdict == "fail" and row(math.inf).verdict == "fail"
    assert row(103.0, absolute=True).verdict == "fail" and row(101.5, absolute=True).verdict == "pass"
    assert row(standing="skipped").verdict == "skipped"
    # A number kept from an earlier run still refutes.
    assert row(97.0, standing="skipped").verdict == "fail"
    assert row(50.0, standing="not judged").verdict == "not judged"


def test_frictionless_upsetting_passes():
    result = by_name("upset-frictionless").run()
    assert [r.verdict for r in result.rows] == ["pass"] * 3
    assert result.rows[0].reference == pytest.approx(224.56, rel=5e-4)
    assert not result.failed and result.seconds > 0.0


def test_a_flow_stress_3_percent_too_high_is_found(monkeypatch):
    steel = upsetting.steel_16MnCr5()
    monkeypatch.setattr(upsetting, "steel_16MnCr5", lambda: replace(steel, A=1.03 * steel.A))
    result = by_name("upset-frictionless").run()
    assert result.failed
    assert result.rows[0].verdict == "fail" and result.rows[0].deviation == pytest.approx(2.7, abs=0.3)


def test_wrong_friction_is_found():
    """Half the friction at mu 0.1 moves the bore by far more than 3 points."""
    for factor, verdict in ((1.0, "pass"), (0.5, "fail")):
        ours = {mu: ring.readings(ring.ring(), factor * mu) for mu in (0.1, 0.4)}
        outcome = ring._calibration("mu", ours)
        assert [row.verdict for row in outcome.rows] == [verdict, "not judged"]
        assert "worst of 5 readings (mu 0.1" in outcome.rows[0].quantity
        assert f"{sum(d <= 3.0 for d in _differences(ours))} of 10 readings" in outcome.details


def _differences(ours):
    return [abs(a - b) for mu in ours for a, b in zip(ours[mu], ring_closed_form.BY_MU[mu])]


@pytest.mark.parametrize("m", [0.05, 0.2])
def test_ring_calibration_for_constant_shear(m):
    ours = ring.readings(ring.ring(m), ring.CONSTANT_SHEAR, len(ring.REDUCTIONS))
    assert ours == pytest.approx(ring.BY_M[m], abs=ring.POINTS)


@pytest.mark.parametrize(("law", "value"), [("mu", 0.02), ("mu", 0.2), ("m", 0.05), ("m", 0.4)])
def test_a_straight_bore_that_does_not_harden_meets_the_closed_form(law, value):
    """Within 1 point; friction over the free side beside a contact, too, would miss m 0.05 by 14."""
    ours = ring_closed_form.straight_readings(law, value)[:5]
    assert ours == pytest.approx(ring_closed_form.CURVES[law][value][:5], abs=1.0)


def test_readings_within_the_tolerance_are_counted():
    closed = ring_closed_form.BY_M[0.3]
    ours = {0.3: [closed[0] + 2.9, closed[1] - 3.1, *closed[2:]]}
    assert ring_closed_form.within("m", ours) == ring_closed_form.Within(5, 6)
    row = ring_closed_form.worst("m", ours, [0.3])
    assert row.verdict == "fail" and row.deviation == pytest.approx(-3.1)
    assert row.quantity == "bore decrease, m 0.3, worst of 6 readings (m 0.3, 20 %)"


def test_friction_by_shear_factor_is_constant():
    """Wherever the surface slides fast, tau is m k whatever the pressure."""
    process = ring.ring(0.3)
    process.start(ring.CONSTANT_SHEAR)
    process.advance(0.8)
    assert process.max_tau_over_k == pytest.approx(0.3, abs=0.002)


#: CalculiX computes each deck of this module once.
known = functools.cache(calculix.compress)


@pytest.fixture
def once(monkeypatch):
    monkeypatch.setattr(calculix, "compress", known)


@pytest.mark.usefixtures("once")
def test_ring_meets_calculix_or_says_that_it_is_skipped():
    result = by_name("ring-calculix").run()
    verdicts = {r.quantity: r.verdict for r in result.rows}
    expected = "skipped" if calculix.executable() is None else "pass"
    assert verdicts.pop("force at 50 %") == expected
    assert verdicts.pop("bore radius at middle height") == expected
    assert set(verdicts.values()) == {"pass"}


@CCX
@pytest.mark.usefixtures("once")
def test_calculix_gives_what_was_kept_of_it():
    found = calculix.compress(ring.in_calculix(0.1))
    kept = ring.KEPT[0.1]
    assert found.force == pytest.approx(kept["force"], rel=2e-3)
    assert found.bore_middle == pytest.approx(kept["bore_middle"], rel=2e-3)
    # The bore first grows a little, then shrinks.
    assert found.history[-1, 0] == pytest.approx(0.5, abs=1e-6)
    assert found.bore_at(0.2) > 3.0 > found.bore_at(0.45) > found.bore_at(0.5)


def test_without_calculix_the_rows_are_skipped_and_say_so(monkeypatch):
    monkeypatch.setattr(calculix.shutil, "which", lambda name: None)
    result = by_name("ring-calculix").run()
    first = result.rows[0]
    assert first.verdict == "skipped" and first.reference == ring.KEPT[0.1]["force"]
    assert "not installed" in first.note and "value kept from 2026-" in first.source
    table = text_table([result])
    assert "skipped" in table and "calculix-ccx" in table and "2 skipped" in summary([result])


def test_a_calculix_run_that_stops_is_no_reference():
    with pytest.raises(CalculixError, match=r"stopped at 0\.0 %"):
        calculix._read(Compression(6.0, 3.0, 4.0, 0.1, 8, 6), "", "2.20")


def test_the_deck_is_that_of_the_ring():
    deck = input_deck(ring.in_calculix(0.1)).splitlines()
    nodes = deck[1 : deck.index("*NODE,NSET=PLATENNODES")]
    radii = [float(line.split(",")[1]) for line in nodes]
    assert (min(radii), max(radii)) == (3.0, 6.0)
    assert deck.count("*ELEMENT,TYPE=CAX8R,ELSET=BILLET") == 1
    assert "0.1,20000" in deck and "PLATENNODES,2,2,-1.0001" in deck
    # A ring is free at its bore, a cylinder is held on the axis.
    assert "AXIS,1,1" not in deck
    assert "AXIS,1,1" in input_deck(Compression(7.5, 0.0, 15.0, 0.1, 4, 4)).splitlines()


def test_dipper_gives_the_published_numbers():
    """D 20, d 14, h0 20: 306 and 325 kN at h1 10 for mu 0 and 0.08; 285 kN at h1 6."""
    for h1, mu, force in ((10.0, 0.0, 306.0), (10.0, 0.08, 325.0), (6.0, 0.0, 285.0)):
        assert extrusion.dipper(20.0, 14.0, 20.0, h1, mu) == pytest.approx(force, abs=0.6)


def test_published_flow_stress_spot_values():
    """kf(strain, T, rate) of the published coefficients."""
    for strain, T, rate, value in ((0.1, 20, 1, 525.9), (1, 20, 10, 707.0), (1, 200, 1, 578.6)):
        assert float(case.published_flow_stress(strain, T, rate)) == pytest.approx(value, rel=1e-3)


def test_a_run_that_stops_is_a_failed_row_with_the_reason():
    def stops():
        raise Unfinished("ring: stopped at stroke 1.2 mm")

    result = Case("x", "Upsetting", "t", stops).run()
    assert result.failed and "stopped at stroke 1.2 mm" in result.rows[0].note
    assert "stopped at stroke 1.2 mm" in text_table([result])


def test_table_and_page():
    results = [Case("one", "Upsetting", "A case.", lambda: [row(), row(110.0)]).run()]
    lines = text_table(results).splitlines()
    assert lines[0].split() == list(COLUMNS)
    assert lines[1].split() == ["one", "force", "100.0", "kN", "101.0", "kN", "+1.00", "%", "2", "%", "pass"]
    assert lines[2].endswith("fail") and lines[-1].startswith("2 rows: 1 pass, 1 fail")
    page = markdown_page(results)
    assert (
        "## Upsetting" in page
        and "| one | force | 100.0 kN | 101.0 kN | +1.00 % | 2 % | pass | a book |" in page
    )
    assert cells(row(absolute=True))[4:6] == ("+1.00 kN", "2 kN")


def test_cases_have_names_of_their_own_and_some_are_fast():
    cases = chosen([], False)
    names = [case.name for case in cases]
    assert len(set(names)) == len(names) > len(CASES)
    assert 0 < len(chosen([], True)) < len(cases)
    assert all(case.title.endswith(".") for case in cases)
    with pytest.raises(InputError, match="ring-calculix"):
        chosen(["ring-calculux"], False)
    with pytest.raises(InputError, match="--fast"):
        chosen(["fre-mesh"], True)


def test_command_writes_and_fails_with_the_rows(tmp_path, capsys, monkeypatch):
    arguments = [
        "verify",
        "--only",
        "upset-friction",
        "--json",
        str(tmp_path / "r.json"),
        "-o",
        str(tmp_path / "p.md"),
    ]
    assert command(arguments) == 0
    rows = json.loads((tmp_path / "r.json").read_text())["rows"]
    assert [r["verdict"] for r in rows] == ["pass"] * 3
    assert {"reference", "ours", "deviation", "tolerance", "source"} <= set(rows[0])
    assert "# Verification" in (tmp_path / "p.md").read_text()
    assert "upset-frictionless" in capsys.readouterr().out
    monkeypatch.setattr(upsetting, "published_flow_stress", lambda *a: 0.9 * case.published_flow_stress(*a))
    assert command(arguments[:3]) == 1
    assert command(["verify", "--only", "nothing"]) == 2


def by_name(name: str) -> Case:
    return next(case for case in CASES if case.name == name)


def test_where_the_closed_form_is_not_judged_the_bore_bulges():
    """Middle of the bore against the straight bore of equal volume at 50 %: below and above 3 points."""
    for m, mu, judged in (
        (1.0, 0.15, True),
        (0.3, ring.CONSTANT_SHEAR, True),
        (1.0, 0.2, False),
        (0.4, ring.CONSTANT_SHEAR, False),
    ):
        process = ring.ring(m)
        ring.readings(process, mu)
        bulge = 100.0 * (process.bore_radius - process.bore_profile().min()) / 3.0
        assert (bulge <= ring.POINTS) == judged, (m, mu, bulge)
    assert ring.STRAIGHT_UP_TO == {"mu": 0.15, "m": 0.30}
