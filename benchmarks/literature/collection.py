"""The cases: about 250, and about 40 of them for a quick look."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from .case import Case
from .foreign import STYLES
from .law import Law
from .noise import RECIPES, TEN
from .registry import REGISTER, catalogue_laws, faults, get, outside_laws

_SEED = 20_000
_FOREIGN = (
    ("strip_drawing", "pressure_root", "as_is"),
    ("strip_drawing", "", "no_tests"),
    ("strip_drawing", "wear_onset", "shuffled"),
    ("pin_on_disc", "", "as_is"),
    ("pin_on_disc", "stribeck_rational", "no_psi"),
    ("pin_on_disc", "running_in_power", "numbered"),
    ("rock_shear", "rise_eyring", "as_is"),
    ("rock_shear", "rate_state_prz", "single_test"),
    ("rock_shear", "", "no_psi"),
    ("hot_strip", "breakdown_weibull", "gaps"),
    ("hot_strip", "", "shuffled"),
    ("hot_strip", "out_resonance", "as_is"),
    ("sliding_compression", "", "gaps"),
    ("sliding_compression", "stribeck_brown", "no_tests"),
)
_THIN = (
    ("four", ""),
    ("four", "stribeck_rational"),
    ("eight", ""),
    ("eight", "breakdown_weibull"),
    ("one_level", ""),
    ("one_level", "running_in_power"),
    ("one_speed", ""),
    ("one_speed", "pressure_root"),
    ("corner", ""),
    ("corner", "softening_wlf"),
    ("eight", "out_reflow"),
    ("one_speed", "out_glaze_window"),
)


def _usable(law: Law, recipe: str) -> bool:
    """Averages cannot show what only happens inside a test; thirty tests give few points for four loads."""
    return not (RECIPES[recipe].averaged and law.within_only)


def _recipes_for(laws: list[Law], rng: np.random.Generator, n: int) -> list[str]:
    """Recipes for n cases: the plain one first, then different ones that can show the laws."""
    fitting = [r for r in TEN if all(_usable(law, r) for law in laws)]
    return (["plain"] + [str(r) for r in rng.permutation(fitting)])[:n]


def _compatible(a: Law, b: Law) -> bool:
    """Two laws of different mechanisms: no common right name or twin."""
    return not (a.near() & b.near())


def _groups(rng: np.random.Generator, size: int, count: int) -> list[tuple[str, ...]]:
    """Random groups of laws; each law is used about equally often."""
    laws = catalogue_laws()
    used = dict.fromkeys((law.key for law in laws), 0)
    chosen: list[tuple[str, ...]] = []
    while len(chosen) < count:
        order = sorted(laws, key=lambda law: (used[law.key], rng.random()))
        group = [order[0]]
        for law in order[1:]:
            if len(group) < size and all(_compatible(law, other) for other in group):
                group.append(law)
        keys = tuple(sorted(law.key for law in group))
        if len(group) == size and keys not in chosen:
            chosen.append(keys)
        for law in group:
            used[law.key] += 1
    return chosen


def cases(points: int = 120) -> list[Case]:
    """All cases, the same list at every call.

    Parameters
    ----------
    points : int
        Points a test.

    Returns
    -------
    list of Case
        About 250 cases.
    """
    rng = np.random.default_rng(7)
    made: list[Case] = []

    def put(
        kind: str,
        laws: tuple[str, ...],
        recipe: str,
        name: str,
        ratio: tuple[float, float] = (0.7, 3.0),
        domain: str = "sliding_compression",
        style: str = "",
    ) -> None:
        made.append(
            Case(
                f"{kind}-{len(made):03d}-{name}",
                kind,
                laws,
                recipe,
                _SEED + len(made),
                ratio,
                domain,
                style,
                points,
            )
        )

    for recipe in RECIPES:
        for i in range(8 if recipe == "plain" else 5):
            put("null", (), recipe, f"{recipe}-{i}")
    for law in (*catalogue_laws(), *faults()):
        for recipe in _recipes_for([law], rng, 3 if not law.fault else 2):
            put("single", (law.key,), recipe, f"{law.key}-{recipe}")
    for law in outside_laws():
        for recipe in _recipes_for([law], rng, 3):
            if (
                recipe == "averages"
            ):  # one row a test and no shape in a test: an outside law cannot be told there
                recipe = "skewed"
            put("outside", (law.key,), recipe, f"{law.key}-{recipe}", (1.0, 3.0))
    everyday = (
        "plain",
        "plain",
        "skewed",
        "heteroscedastic",
        "quantised",
        "half_tests",
        "unbalanced",
        "mains_hum",
        "random_walk",
        "odd_tests",
    )
    for i, keys in enumerate(_groups(rng, 2, 28)):
        put("pair", keys, everyday[i % len(everyday)], "+".join(keys), (1.0, 3.0))
    for i, keys in enumerate(_groups(rng, 3, 8)):
        put("triple", keys, everyday[i % len(everyday)], "+".join(keys), (1.0, 3.0))
    pool = [law for law in catalogue_laws() if law.factors]
    for i, strange in enumerate(outside_laws()):
        free = [law for law in pool if not set(law.factors) & set(strange.factors)] or pool
        known = free[int(rng.integers(len(free)))]
        put(
            "mixed",
            (known.key, strange.key),
            everyday[i % len(everyday)],
            f"{known.key}+{strange.key}",
            (1.0, 3.0),
        )
    for i in range(4):
        put("hidden_group", (), ("plain", "skewed", "half_tests", "unbalanced")[i], f"group-{i}")
    for style, key in _THIN:
        put("thin", (key,) if key else (), "plain", f"{style}-{key or 'null'}", (1.0, 3.0), style=style)
    for domain, key, style in _FOREIGN:
        put(
            "foreign",
            (key,) if key else (),
            "plain",
            f"{domain}-{key or 'null'}-{style}",
            (1.0, 3.0),
            domain,
            style,
        )
    return made


def quick(points: int = 120) -> list[Case]:
    """About 40 of the cases, spread evenly over the kinds and over the laws of each kind."""
    share = {
        "null": 8,
        "single": 14,
        "pair": 5,
        "triple": 1,
        "outside": 4,
        "mixed": 2,
        "hidden_group": 1,
        "thin": 2,
        "foreign": 3,
    }
    everything = cases(points)
    chosen: list[Case] = []
    for kind, count in share.items():
        some = [case for case in everything if case.kind == kind]
        # An odd offset keeps the selection from taking the plain recipe every time.
        places = (np.arange(count) * len(some) / count + 0.37 * len(some) / count).astype(int)
        chosen += [some[i] for i in places]
    return chosen


def check_catalogue() -> dict[str, int]:
    """Number of laws a kind, and that every key used here exists.

    Raises
    ------
    KeyError
        If a case names a law that is not registered.
    ValueError
        If a foreign style is not known.
    """
    for case in cases():
        for key in case.laws:
            get(key)
        if case.kind == "foreign" and case.style not in STYLES:
            raise ValueError(f"{case.id}: style {case.style!r} is unknown")
    clashes = [(a, b) for a, b in combinations(REGISTER, 2) if a == b]
    return {
        "catalogue": len(catalogue_laws()),
        "faults": len(faults()),
        "outside": len(outside_laws()),
        "clashes": len(clashes),
    }
