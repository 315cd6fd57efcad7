"""``python -m benchmarks.friction_cards --data FOLDER``: write the friction cards that are fitted to public measurements.

FOLDER holds the measurements as `benchmarks.measured` reads them; sources and licences stand in `benchmarks.measured.origins` and go
into the cards. Each law is fitted to all tests; its held-out error comes from fits that did not see the tests they are judged on.
Without FOLDER nothing is written. The cards of published laws are written by hand from their sources.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import pandas as pd
import yaml

from friction_models.cards.card import card_from
from friction_models.common import write_text
from friction_models.families.formula import FormulaFriction
from friction_models.loads import LOADS, FloatArray
from friction_models.models.domain import Domain

from .measured import tables
from .measured.origins import ORIGINS

OUT = Path(__file__).parents[1] / "friction_models" / "cards" / "data"
#: Laws of the cards.
INVERSE = "mu0 + F0/sigma_n"
POWER = "mu0*(sigma_n/p0)**n*(v_rel/v0)**m"
CUBIC = "a + b*log(sigma_n/p0) + c*log(sigma_n/p0)**2 + d*log(sigma_n/p0)**3"


@dataclass(frozen=True)
class Wanted:
    """One card: texts, which tests, which law, and what is held out together."""

    name: str
    title: str
    lubricant: str
    workpiece: str
    tool: str
    test: str
    origin: str
    read: Callable[[Path], tables.Table]
    law: str
    start: dict[str, float]
    fixed: tuple[str, ...] = ()
    groups: str = "test"
    measured: str = ""
    keywords: tuple[str, ...] = ()


def seal(ring: str, material: str) -> Wanted:
    return Wanted(
        name="seal-" + ring.lower().replace("257", "-257").replace("310", "-310"),
        title=f"Pneumatic seal ring {ring} in a printed cylinder",
        lubricant="not stated by the source",
        workpiece="printed cylinder",
        tool=f"seal ring {ring}{material}",
        test="strokes of a pneumatic cylinder under 1, 3, 5 and 7 bar",
        origin="pneumatic_seal",
        read=lambda folder: tables.pneumatic_seal(folder, ring=ring, fill_missing=False),
        law=INVERSE,
        start={"mu0": 0.03, "F0": 0.005},
        groups="level",
        measured="friction force, air pressure and speed of ten strokes at each of four pressures; mu = force over pressure times area",
        keywords=("seal", "pneumatic", "pressure", "low pressure"),
    )


def composite(share: str, label: str) -> Wanted:
    return Wanted(
        name="al10cu-" + label,
        title="Al-10Cu alloy, dry" if label == "alloy" else f"Al-10Cu with 2 % MoS2 and {share} % Al2O3, dry",
        lubricant="none" if label == "alloy" else "none (2 % MoS2 in the material)",
        workpiece="aluminium alloy Al-10Cu"
        if label == "alloy"
        else f"composite of Al-10Cu, 2 % MoS2, {share} % Al2O3",
        tool="disc, its material is not stated",
        test="pin on disc, 50 N, 333 mm/s, 7 minutes",
        origin="al10cu_composites",
        read=lambda folder: _batch(tables.al10cu_composites(folder, fill_missing=False), f"Al2O3_{share}"),
        law="mu0",
        start={"mu0": 0.4},
        measured="friction force of three runs; the area of the pin is not known, so there is no pressure",
        keywords=("aluminium", "composite", "dry", "pin on disc"),
    )


def pla(name: str, silicone: str, law: str, start: dict[str, float], fixed: tuple[str, ...] = ()) -> Wanted:
    return Wanted(
        name=name.replace("_", "-").replace("dragonskin", "dragon-skin").replace("sil950", "sil-950"),
        title=f"Printed PLA on silicone {silicone}",
        lubricant="none",
        workpiece=f"silicone {silicone}",
        tool="printed PLA plate, 4 x 4 mm",
        test="nanotribometer, rising loads on one track, 10 mm/s",
        origin=name,
        read=lambda folder: getattr(tables, name)(folder, fill_missing=False),
        law=law,
        start=start,
        fixed=fixed,
        groups="block",
        measured="mean mu of each turn at each load; the loads rose with time on one track, so load and wear are not told apart",
        keywords=("polymer", "silicone", "robotics", "low pressure"),
    )


WANTED = (
    Wanted(
        name="motor-oil-steel-glass",
        title="Steel on glass in 20W-50 motor oil",
        lubricant="20W-50 motor oil",
        workpiece="glass",
        tool="steel flat, 8 mm",
        test="rotating flat on glass, 24 pairs of load and speed",
        origin="motor_oil",
        read=lambda folder: tables.motor_oil(folder, fill_missing=False),
        law=POWER,
        start={"mu0": 0.05, "n": -0.8, "m": 0.2, "p0": 0.1, "v0": 5.0},
        fixed=("p0", "v0"),
        measured="one mean mu at each load and speed; loads below 1.5 N left out, there the drag of the bearing decides",
        keywords=("oil", "steel", "speed", "pressure"),
    ),
    Wanted(
        name="sepiolite-gouge",
        title="Sepiolite gouge at 30 MPa, one step of the speed",
        lubricant="none",
        workpiece="sepiolite gouge",
        tool="not stated",
        test="speed step from 0.2 to 2 micrometres a second at 30 MPa",
        origin="sepiolite",
        read=lambda folder: tables.sepiolite(folder, pieces=10, fill_missing=False),
        law="mu0 + a*log(max(v_rel, 1e-5)/v0)",
        start={"mu0": 0.47, "a": 0.005, "v0": 0.0002},
        fixed=("v0",),
        measured="friction over time; ONE test, of which ten consecutive pieces are held out in turn: no scatter between tests; its memory "
        "(spike and decay after the step) is not in this law",
        keywords=("rock", "clay", "speed", "rate and state"),
    ),
    *(seal(r, "") for r in ("KDN", "NAP310", "NAPN", "O-ring", "O-ring257", "PK", "X-ring257")),
    composite("0", "alloy"),
    composite("2.5", "mos2-al2o3-2-5"),
    composite("5", "mos2-al2o3-5"),
    composite("7.5", "mos2-al2o3-7-5"),
    pla(
        "pla_dragonskin", "Dragon Skin", CUBIC, {"a": 1.5, "b": 0.0, "c": 0.0, "d": 0.0, "p0": 0.005}, ("p0",)
    ),
    # Two turning points over the load: no smooth law predicts a block that was left out better than the mean does.
    pla("pla_sil950", "Sil 950", "mu0", {"mu0": 1.0}),
)


def _batch(table: tables.Table, batch: str) -> tables.Table:
    points, tests, text = table
    chosen = tests[tests["batch"] == batch]["test_id"]
    return points[points["test_id"].isin(chosen)].reset_index(drop=True), tests[tests["batch"] == batch], text


def held_out_groups(points: pd.DataFrame, kind: str) -> tuple[FloatArray, str]:
    """Return the group of each point that is left out together, and how to call it."""
    tests = points["test_id"].unique()
    if kind == "level":
        level = points["test_id"].str.extract(r"_(\d+bar)_")[0]
        return level.to_numpy(), "all strokes at one pressure left out at a time"
    if kind == "block":
        number = pd.Series(np.arange(len(tests)) * 10 // len(tests), index=tests)
        return number.loc[
            points["test_id"]
        ].to_numpy(), "ten blocks of neighbouring loads, one left out at a time"
    return points["test_id"].to_numpy(), "one test left out at a time"


def fitted(wanted: Wanted, loads: FloatArray, mu: FloatArray, weights: FloatArray) -> FormulaFriction:
    """Fit the constants of the law that are not fixed, every test alike."""
    text = wanted.law
    for name in wanted.fixed:
        text = _replaced(text, name, wanted.start[name])
    start = {k: v for k, v in wanted.start.items() if k not in wanted.fixed}
    return FormulaFriction(text, start).fit(loads, mu, sample_weight=weights)


def _replaced(text: str, name: str, value: float) -> str:
    import re

    return re.sub(rf"\b{name}\b", repr(value), text)


def made(wanted: Wanted, folder: Path) -> dict[str, object]:
    """Return the content of a card."""
    points, _, _ = wanted.read(folder)
    points = points.dropna(subset=["mu"]).reset_index(drop=True)
    domain, columns = {}, []
    for q in LOADS:
        recorded = q.name in points and q.name not in ("sd", "psi")
        columns.append(points[q.name].to_numpy(float) if recorded else np.full(len(points), q.nominal))
        if recorded:
            domain[q.name] = [_rounded(columns[-1].min(), 4), _rounded(columns[-1].max(), 4)]
    loads, mu = np.column_stack(columns), points["mu"].to_numpy(float)
    tests = points["test_id"].to_numpy()
    weights = 1.0 / points.groupby("test_id")["mu"].transform("size").to_numpy(float)
    groups, how = held_out_groups(points, wanted.groups)
    off, plain = np.empty(len(mu)), np.empty(len(mu))
    for group in np.unique(groups):
        seen = groups != group
        model = fitted(wanted, loads[seen], mu[seen], weights[seen])
        model.domain_ = fitted_domain(domain)
        off[~seen] = model.predict(loads[~seen]) - mu[~seen]
        plain[~seen] = np.average(mu[seen], weights=weights[seen]) - mu[~seen]
    means = pd.Series(off).groupby(tests).mean()
    law = fitted(wanted, loads, mu, weights)
    origin = ORIGINS[wanted.origin]
    constants = {k: _rounded(v, 5) for k, v in law.constants_.items()} | {
        k: wanted.start[k] for k in wanted.fixed
    }
    return {
        "name": wanted.name,
        "title": wanted.title,
        "lubricant": wanted.lubricant,
        "workpiece": wanted.workpiece,
        "tool": wanted.tool,
        "test": wanted.test,
        "basis": "measured",
        "measured": wanted.measured,
        "synthetic": "nothing; the law is a fit",
        "law": wanted.law,
        "constants": constants,
        "domain": domain,
        "uncertainty": {
            "mu": _rounded(float(np.sqrt((means**2).mean())), 3),
            "of": "root mean square of the mean deviation of the tests left out",
        },
        "held_out": {
            "rmse": _rounded(_rmse(off, weights), 3),
            "constant_rmse": _rounded(_rmse(plain, weights), 3),
            "tests": len(np.unique(tests)),
            "points": len(mu),
            "how": how,
        },
        "source": {
            "text": f"{origin.title}: {origin.source.replace('`', '')}",
            "address": "https://github.com/" + _repository(origin.source),
            "licence": origin.licence,
        },
        "keywords": list(wanted.keywords),
    }


def fitted_domain(domain: dict[str, list[float]]) -> Domain:
    """Return the domain of all tests: a law of fewer tests is asked where it was not fitted."""
    return Domain.from_dict({q.name: domain.get(q.name) for q in LOADS})


def _rmse(off: FloatArray, weights: FloatArray) -> float:
    return float(np.sqrt(np.average(off**2, weights=weights)))


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def _repository(source: str) -> str:
    """Return owner/name from a text such as ``NAME by OWNER at COMMIT``."""
    words = source.replace(",", " ").replace("(", " ").split()
    return f"{words[words.index('by') + 1]}/{words[0]}"


def main() -> None:
    """Write the cards and print their held-out errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True, help="folder of the measurements")
    parser.add_argument("-o", "--out", type=Path, default=OUT)
    given = parser.parse_args()
    for wanted in WANTED:
        content = made(wanted, given.data)
        card = card_from(content, wanted.name, wanted.name)
        text = yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=110)
        write_text(given.out / f"{wanted.name}.yaml", text)
        assert card.held_out is not None
        print(
            f"{wanted.name:28} {card.held_out.rmse:8.4f} {card.held_out.constant_rmse:8.4f}  {card.model().formula_text()}"
        )


if __name__ == "__main__":
    main()
