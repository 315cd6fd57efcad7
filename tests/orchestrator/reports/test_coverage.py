"""Coverage of a forming process by tested loads: made-up tests and histories with known answers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models.common import InputError
from orchestrator.cli.commands import covering
from orchestrator.cosim.run_folders import Run
from orchestrator.coverage.contact_states import ContactStates
from orchestrator.coverage.proposals import Rig, propose_tests
from orchestrator.coverage.tested_loads import Coverage, coverage
from orchestrator.report.pages.coverage import coverage_page


def campaign() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Eighteen tests: fast ones get hot, slow ones stay cold."""
    points, rows = [], []
    sd = np.linspace(0.1, 40.0, 60)
    for k, (sigma, v, T_tool) in enumerate(
        (s, v, T) for s in (500.0, 1500.0, 2500.0) for v in (5.0, 50.0, 500.0) for T in (20.0, 100.0)
    ):
        T = T_tool + 1.2e-3 * sigma * np.sqrt(v * sd)
        loads = {"v_rel": v, "T": T, "sigma_n": sigma, "sd": sd, "psi": 1.05 if k % 2 else 1.5}
        points.append(pd.DataFrame({"test_id": f"t{k}", **loads, "mu": 0.08}))
        rows.append(
            {
                "test_id": f"t{k}",
                "sigma_set": sigma,
                "v_set": v,
                "T_tool": T_tool,
                "psi_set": 1.069 if k % 2 else 5.0,
            }
        )
    return pd.concat(points, ignore_index=True), pd.DataFrame(rows)


def states(**loads: float) -> ContactStates:
    usual = {"v_rel": 60.0, "T": 120.0, "sigma_n": 1200.0, "sd": 10.0, "psi": 1.2}
    row = np.array([[{**usual, **loads}[n] for n in ("v_rel", "T", "sigma_n", "sd", "psi")]])
    one = np.full(4, 0.25)
    return ContactStates(np.repeat(row, 4, axis=0), one, one, "made up")


def share(found: Coverage, *names: str) -> float:
    return next(s.area for s in [*found.loads, *found.pairs] if s.names == names)


def test_tested_states_are_inside_and_each_load_beyond_is_named() -> None:
    points, _ = campaign()
    assert coverage(points, states()).whole.area == 0.0
    for name, value in {"v_rel": 900.0, "T": 900.0, "sigma_n": 300.0, "sd": 60.0, "psi": 2.5}.items():
        found = coverage(points, states(**{name: value}))
        assert share(found, name) == pytest.approx(1.0)
        assert all(s.area == 0.0 for s in found.loads if s.names != (name,))
        assert found.whole.work == pytest.approx(1.0) and name in found.sentence
        assert repr(found) == f"Coverage({found.sentence!r})"


def test_an_untested_pair_of_tested_loads_is_outside() -> None:
    points, _ = campaign()
    found = coverage(points, states(v_rel=6.0, T=280.0))  # hot, yet slow: each was tested, never together
    assert share(found, "v_rel") == share(found, "T") == 0.0
    assert share(found, "v_rel", "T") == pytest.approx(1.0) and found.whole.area == pytest.approx(1.0)


def test_shares_are_weighted_by_area_and_by_work() -> None:
    points, _ = campaign()
    loads = np.vstack([states().loads[:3], states(sigma_n=200.0).loads[:1]])
    history = ContactStates(loads, np.array([0.2, 0.2, 0.2, 0.4]), np.array([0.3, 0.3, 0.3, 0.1]), "made up")
    found = coverage(points, history)
    assert found.whole.area == pytest.approx(0.4) and found.whole.work == pytest.approx(0.1)


def test_constant_tested_loads_have_no_inside_but_themselves() -> None:
    points, _ = campaign()
    one = points[points["test_id"] == "t0"].assign(T=20.0, v_rel=5.0)
    assert coverage(one, states()).whole.area == pytest.approx(1.0)
    same = states(v_rel=5.0, T=20.0, sigma_n=500.0, psi=1.5)
    assert coverage(one, same).whole.area == 0.0


def test_proposed_tests_cover_what_they_promise_within_the_rig() -> None:
    points, tests = campaign()
    found = coverage(points, states(sigma_n=2900.0, T=90.0))
    propose_tests(found, points, tests, Rig(sigma_set=(500.0, 3000.0), sd_set=(5.0, 50.0)))
    assert (
        found.proposals[0]["setpoints"]["sigma_set"] >= 2800.0 and found.proposals[-1]["work_covered"] > 0.9
    )
    for proposal in found.proposals:
        row = proposal["plan"][0]
        assert row["protocol"] == "constant" and 500.0 <= row["sigma_set"] <= 3000.0
        assert 5.0 <= row["v_set"] <= 500.0 and row["sd_set"] <= 50.0
    beyond = coverage(points, states(sigma_n=4000.0))
    propose_tests(beyond, points, tests)
    assert any("sigma_n above" in text for text in beyond.beyond_rig)
    inside = coverage(points, states())
    propose_tests(inside, points, tests)
    assert not inside.proposals and inside.sentence.startswith("All but")


def test_history_with_foreign_names_units_and_signs(tmp_path: Path) -> None:
    file = tmp_path / "forge.csv"
    file.write_text(
        "Zeit;Knoten;Kontaktdruck (GPa);Gleitgeschw.;Temp;Flaeche\ns;-;GPa;m/s;K;mm2\n"
        "0,0;1;1,2;-0,05;373,15;2,0\n0,1;1;1,3;0,06;383,15;2,0\n0,0;2;-0,1;0;293,15;1,0\n0,1;2;1,0;0,04;363,15;1,0\n",
        encoding="utf-8",
    )
    history = ContactStates.read(
        file,
        {
            "t": "Zeit",
            "point": "Knoten",
            "sigma_n": "Kontaktdruck",
            "v_rel": "Gleitgeschw.",
            "T": "Temp",
            "area": "Flaeche",
        },
    )
    assert history.present == ("v_rel", "T", "sigma_n")
    assert len(history.loads) == 3  # one row is not in contact
    np.testing.assert_allclose(history.loads[0, :3], [50.0, 100.0, 1200.0], atol=1e-9)
    assert history.area.sum() == pytest.approx(1.0) and history.work.sum() == pytest.approx(1.0)
    found = coverage(campaign()[0], history)
    assert [s.names[0] for s in found.loads] == ["v_rel", "T", "sigma_n"]
    assert any("lacks sd, psi" in n for n in found.notes)
    assert json.dumps(found.to_dict(), allow_nan=False)


@pytest.mark.parametrize(
    ("text", "columns", "message"),
    [
        ("a,b\n1,2\n", {}, "none of its columns is a load"),
        ("sigma_n [MPa],v_rel,sd\n100,1,5\n100,x1,5\n", {}, "finite number"),
        ("sigma_n [kN],v_rel\n100,1\n", {}, "unit of 'sigma_n'"),
        ("p,v_rel\n100,1\n", {"sigma_n": "pp"}, "'pp'"),
        ("p,v_rel\n100,1\n", {"sigma": "p"}, "did you mean 'sigma_n'"),
        ("sigma_n,v_rel\n0,1\n", {}, "nothing is in contact"),
        ("sigma_n,T\n100,9000\n", {}, "T = 9000"),
    ],
)
def test_bad_histories_are_refused_in_a_sentence(
    tmp_path: Path, text: str, columns: dict[str, str], message: str
) -> None:
    file = tmp_path / "bad.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        ContactStates.read(file, columns)


def a_run(folder: Path, **more: np.ndarray) -> Run:
    time, n = np.linspace(0.0, 1.0, 6), 4
    values = {
        f"press.{k}": np.full((6, n), v)
        for k, v in {"v_rel": 60.0, "T": 120.0, "sigma_n": 1200.0, "sd": 10.0, "psi": 1.2}.items()
    }
    values["press.active"] = np.ones((6, n))
    values["law.mu"] = np.full((6, n), 0.1)
    return Run(folder, {"synthetic": True, "name": "made up"}, time, {**values, **more}, {})


def test_history_of_a_run_counts_touching_markers_by_expansion(tmp_path: Path) -> None:
    run = a_run(tmp_path)
    run.values["press.active"][:, 3] = 0.0
    run.values["press.psi"][:, 0] = 2.4
    history = ContactStates.of_run(run)
    assert history.synthetic and len(history.loads) == 18
    assert history.area[history.loads[:, 4] == 2.4].sum() == pytest.approx(0.5)
    with pytest.raises(InputError, match="no component recorded"):
        ContactStates.of_run(Run(tmp_path, {}, run.time, {"a.force": run.time}, {}))


def test_the_command_writes_text_json_plan_and_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    points, tests = campaign()
    points.to_csv(tmp_path / "points.csv", index=False)
    tests.to_csv(tmp_path / "tests.csv", index=False)
    history = tmp_path / "history.csv"
    history.write_text(
        "v_rel,T,sigma_n,sd,psi,mu\n450,110,2700,12,1.2,0.09\n400,300,2700,14,1.2,0.08\n", encoding="utf-8"
    )
    app = covering.app
    out = {k: tmp_path / f"out.{k}" for k in ("json", "html", "csv")}
    app(
        ["--data", str(tmp_path), "--history", str(history), "--json", str(out["json"]), "--report", str(out["html"]),
         "--plan", str(out["csv"])],
        standalone_mode=False,
    )  # fmt: skip
    said = capsys.readouterr().out
    assert "% of the friction work lie outside" in said and "Tests that would cover more" in said
    content = json.loads(out["json"].read_text())
    assert content["outside"]["work"] == pytest.approx(1.0) and content["proposed_tests"]
    page = out["html"].read_text()
    assert "Pairs of loads" in page and 'src="http' not in page
    assert list(pd.read_csv(out["csv"]).columns) == [
        "test_id",
        "protocol",
        "sigma_set",
        "psi_set",
        "v_set",
        "T_tool",
        "sd_set",
    ]
    with pytest.raises(InputError, match="either --run"):
        app(["--data", str(tmp_path)], standalone_mode=False)


@pytest.mark.parametrize("text", ["v=1:2", "v_set=5", "v_set=9:5", "v_set=a:b", "psi_set=0"])
def test_bad_limits_of_the_rig_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="allowed"):
        Rig.read([text])


def test_the_page_of_a_run_escapes_its_name(tmp_path: Path) -> None:
    points, _ = campaign()
    found = coverage(points, ContactStates.of_run(a_run(tmp_path)))
    html = coverage_page(found, "<b>x</b>")
    assert "<b>x</b>" not in html and "synthetic data" in html
