"""Campaigns that hide a law outside the catalogue, from three sources, with what the truth avoids on held-out tests."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from friction_models.families import make_model

from .. import literature
from ..discovery import study
from ..discovery.generator import campaign
from ..literature.build import make
from .laws import LAWS

Array = NDArray[np.float64]
#: Every third case was left alone while the terms were changed.
THIRDS, UNSEEN = 3, 2
#: Rounds of the forms of `benchmarks.discovery`: each form twice.
SEEDS = 6
#: Noise of the laws of `laws`: each law under two recipes.
RECIPES = (
    "plain",
    "skewed",
    "heteroscedastic",
    "quantised",
    "half_tests",
    "unbalanced",
    "mains_hum",
    "random_walk",
)
SEED = 71_000


@dataclass(frozen=True)
class Case:
    """One campaign.

    Attributes
    ----------
    source : {"forms", "literature", "physics"}
    law : str
    number : int
        In the list of the source.
    given : object
        The case as its source knows it.
    """

    source: str
    law: str
    number: int
    given: Any

    @property
    def unseen(self) -> bool:
        """Whether the case was left alone."""
        return self.number % THIRDS == UNSEEN

    @property
    def key(self) -> str:
        """Name of its file."""
        return f"{self.source}-{self.number:03d}-{self.law}".replace(" ", "_")


@dataclass
class Hidden:
    """A campaign and its truth.

    Attributes
    ----------
    data, tests : pandas.DataFrame
        What `diagnose` and `refine` see.
    held, held_tests : pandas.DataFrame
        Tests at other loads.
    truth : ndarray
        Their mu without noise.
    floor : float
        Mean squared error there of a fit that knows the true form.
    """

    data: pd.DataFrame
    tests: pd.DataFrame
    held: pd.DataFrame
    held_tests: pd.DataFrame
    truth: Array
    floor: float


def cases() -> Iterator[Case]:
    """Yield all cases."""
    forms = [c for c in study.cases(SEEDS) if c.kind == "outside"]
    yield from (Case("forms", c.hidden[0], k, c) for k, c in enumerate(forms))
    for k, c in enumerate(literature.cases()):
        if c.kind == "outside":  # numbered as in the list of that benchmark, whose unseen cases stay unseen
            yield Case("literature", c.laws[0], k, c)
    for k in range(2 * len(LAWS)):
        law = list(LAWS)[k // 2]
        recipe = "plain" if k % 2 == 0 else RECIPES[1 + (k // 2) % (len(RECIPES) - 1)]
        own = literature.Case(f"physics-{k:03d}", "outside", (law,), recipe, SEED + k, (1.0, 3.0))
        yield Case("physics", law, k, own)


def hidden(case: Case) -> Hidden:
    """Return the campaign of a case; equal cases give equal campaigns."""
    if case.source == "forms":
        return _of_forms(case.given)
    made = make(case.given, LAWS) if case.source == "physics" else make(case.given)
    assert made.tests is not None
    floor = float(np.mean((made.floor_mu - made.heldout_mu) ** 2))
    return Hidden(made.data, made.tests, made.heldout_data, made.heldout_tests, made.heldout_mu, floor)


def _of_forms(case: study.Case) -> Hidden:
    """Return a campaign of `benchmarks.discovery`; what a linear law errs where nothing is hidden is not avoidable."""
    made = campaign(case.seed, case.hidden, case.null, case.noise, case.forms)
    points, tests = made.points, made.tests
    named = tests["role"] == "train"
    train = points["test_id"].isin(tests.loc[named, "test_id"]).to_numpy()
    plain = points.assign(mu=np.maximum(points["mu"].to_numpy() - made.part, 1e-3))
    least = make_model("linear").fit_frame(plain[train], tests)
    predicted = least.predict_frame(points[~train], tests)
    floor = float(np.mean((predicted - (made.law - made.part)[~train]) ** 2))
    parts = [points[rows].reset_index(drop=True) for rows in (train, ~train)]
    tables = [tests[rows].drop(columns="role").reset_index(drop=True) for rows in (named, ~named)]
    return Hidden(parts[0], tables[0], parts[1], tables[1], made.law[~train], floor)
