"""`Card`: a friction law with its source, its domain and its uncertainty, read from a YAML file that is checked first."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common import InputError, unknown_name
from ..common.ranges import is_number
from ..common.yaml_files import read_yaml
from ..expressions.formula_text import read_formula
from ..families.formula import MAX_CONSTANTS, FormulaFriction
from ..loads import LOAD_NAMES, LOADS, MU, QUANTITIES, FloatArray
from ..models.domain import Domain

if TYPE_CHECKING:
    import plotly.graph_objects as go

MAX_BYTES = 64 * 1024
MAX_TEXT = 2000
#: Where the numbers of a card come from.
BASES = ("measured", "published", "synthetic")
_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,59}")
_TEXTS = ("title", "lubricant", "workpiece", "tool", "test", "measured", "synthetic")
_KEYS = (
    *_TEXTS,
    *("name", "basis", "keywords", "law", "constants", "domain", "uncertainty", "source", "held_out"),
)
_SOURCE = ("text", "address", "licence")


@dataclass(frozen=True)
class HeldOut:
    """Error on tests that took no part in the fit: of the law, and of the mean of mu; root mean squares over tests alike."""

    rmse: float
    constant_rmse: float
    tests: int
    points: int
    how: str


_HELD_OUT = tuple(f.name for f in fields(HeldOut))


@dataclass(frozen=True)
class Card:
    """One friction law, and what is known about it.

    Attributes
    ----------
    name, title, lubricant, workpiece, tool, test : str
    basis : {"measured", "published", "synthetic"}
        A law fitted to measurements that anyone can have, a law as its source prints it, or one made up.
    measured, synthetic : str
        What of it was measured, and what was not.
    law : str
        Formula of the loads and of `constants`, see `expressions.formula_text`.
    domain : dict of str to (float, float)
        Loads for which the law is meant; of other loads nothing is known.
    uncertainty : float or None
        Standard uncertainty of mu of a new test; None where the source states none.
    uncertainty_of : str
        What that number is.
    source : dict
        ``text``, ``address`` (DOI or URL) and ``licence``.
    held_out : HeldOut or None

    Examples
    --------
    >>> from friction_models.cards import load_card
    >>> card = load_card("cold-forging-median")
    >>> card.model().predict([[50, 20, 500, 0, 1]]).tolist()
    [0.08]
    """

    name: str
    title: str
    lubricant: str
    workpiece: str
    tool: str
    test: str
    basis: str
    measured: str
    synthetic: str
    law: str
    constants: dict[str, float]
    domain: dict[str, tuple[float, float]]
    uncertainty: float | None
    uncertainty_of: str
    source: dict[str, str]
    held_out: HeldOut | None = None
    keywords: tuple[str, ...] = ()

    def model(self) -> FormulaFriction:
        """Return the law as a model that predicts, is saved, packed and compared like any other.

        Examples
        --------
        >>> from friction_models.cards import load_card
        >>> model = load_card("rock-byerlee").model()
        >>> model.predict([[0, 20, 100, 0, 1], [0, 20, 500, 0, 1]]).round(3).tolist()
        [0.85, 0.7]
        """
        model = FormulaFriction(self.law, dict(self.constants))
        model.constants_ = dict(self.constants)
        limits = {n: list(self.domain[n]) if n in self.domain else None for n in LOAD_NAMES}
        model.domain_ = Domain.from_dict(limits)
        model.training_ = {
            "data": {
                "points": self.held_out.points if self.held_out else 0,
                "tests": self.held_out.tests if self.held_out else None,
                "synthetic": self.basis == "synthetic",
                "provenance": {"card": self.name, "basis": self.basis, "source": self.source["text"]},
            }
        }
        return model

    def view(self) -> go.Figure:
        """Return a figure of mu against each load, as every model draws it.

        Examples
        --------
        >>> from friction_models.cards import load_card
        >>> load_card("seal-kdn").view().layout.title.text is not None
        True
        """
        return self.model().view()

    def sample(self, count: int, box: Mapping[str, tuple[float, float]] | None = None) -> FloatArray:
        """Return random loads of the domain, shape (n, 5); a load that the card does not know lies in `box` or at its usual value."""
        rng = np.random.default_rng(0)
        columns = []
        for q in LOADS:
            usual = (q.nominal, q.nominal)
            low, high = self.domain.get(q.name, (box or {}).get(q.name, usual))
            columns.append(rng.uniform(low, high, size=count))
        return np.column_stack(columns)

    def text(self) -> str:
        """Return all of the card for a terminal."""
        rows = [(name, str(getattr(self, name))) for name in ("lubricant", "workpiece", "tool", "test")]
        constants = ", ".join(f"{n} = {v:.5g}" for n, v in self.constants.items())
        rows.append(("law", f"mu = {self.law}" + (f"; {constants}" if constants else "")))
        ranges = [f"{n} {low:g} to {high:g} {QUANTITIES[n].unit}" for n, (low, high) in self.domain.items()]
        rows.append(("domain", "; ".join(ranges) or "no range of a load is stated"))
        u = "" if self.uncertainty is None else f"{self.uncertainty:.2g}: "
        rows.append(("uncertainty", u + self.uncertainty_of))
        if self.held_out:
            h = self.held_out
            errors = f"{h.rmse:.3g} root mean square on tests left out ({h.how}; {h.tests} tests, {h.points} points)"
            rows.append(("held out", f"{errors}; a constant: {h.constant_rmse:.3g}"))
        rows += [("measured", self.measured), ("synthetic", self.synthetic), ("basis", self.basis)]
        rows.append(("source", "; ".join(self.source[k] for k in _SOURCE)))
        lines = [f"{self.name}: {self.title}", *(f"  {k:11} {v}" for k, v in rows)]
        return "\n".join(lines)

    def matches(self, text: str) -> bool:
        """Whether all words of a search stand somewhere in the card.

        Examples
        --------
        >>> from friction_models.cards import load_card
        >>> load_card("rock-byerlee").matches("ROCK pressure"), load_card("rock-byerlee").matches("soap")
        (True, False)
        """
        texts = [getattr(self, k) for k in ("name", "basis", "law", *_TEXTS)]
        whole = " ".join([*texts, *self.domain, *self.keywords, *self.source.values()]).lower()
        return all(word in whole for word in text.lower().split())

    def to_dict(self) -> dict[str, Any]:
        """Return the card as its file holds it."""
        found: dict[str, Any] = {k: getattr(self, k) for k in ("name", *_TEXTS, "basis", "law")}
        found |= {"keywords": list(self.keywords), "constants": dict(self.constants)}
        found["domain"] = {n: list(r) for n, r in self.domain.items()}
        found["uncertainty"] = {"mu": self.uncertainty, "of": self.uncertainty_of}
        found["source"] = dict(self.source)
        if self.held_out:
            found["held_out"] = asdict(self.held_out)
        return found


def read_card(file: Path) -> Card:
    """Read and check a card.

    Raises
    ------
    InputError
        The file is missing, too large, no YAML, or anything in it is not what a card holds.
    """
    if not file.exists():
        raise InputError(f"{file}: no such card; allowed: a YAML file")
    return card_from(read_yaml(file, MAX_BYTES), file.stem, str(file))


def card_from(content: object, name: str, where: str) -> Card:
    """Build a card of the content of a file; see `read_card`.

    Examples
    --------
    >>> card_from({"title": "Soap"}, "soap", "soap.yaml")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: soap.yaml: 'name' is missing; allowed: a text
    """
    given = _mapping(content, where, "a card", _KEYS)
    if _text(given, "name", where) != name or not _NAME.fullmatch(name):
        raise InputError(
            f"{where}: name {given['name']!r:.60}, allowed: that of the file, small letters, digits, '-' and '_'"
        )
    texts = {k: _text(given, k, where) for k in _TEXTS}
    basis = given.get("basis")
    if basis not in BASES:
        raise unknown_name("basis", basis, BASES, where)
    keywords = given.get("keywords", [])
    if not isinstance(keywords, list) or not all(isinstance(k, str) and len(k) < 60 for k in keywords):
        raise InputError(f"{where}: keywords {keywords!r:.60}, allowed: a list of short texts")
    numbers = given.get("constants", {})
    if not isinstance(numbers, dict) or len(numbers) > MAX_CONSTANTS:
        raise InputError(
            f"{where}: constants {numbers!r:.60}, allowed: at most {MAX_CONSTANTS} names with numbers"
        )
    constants = {str(k): _number(v, f"constant {k!r}", where) for k, v in numbers.items()}
    law = _text(given, "law", where)
    read_formula(law, {*LOAD_NAMES, *constants}, f"{where}: law")
    domain = _domain(given.get("domain"), where)
    uncertainty = _mapping(given.get("uncertainty"), where, "uncertainty", ("mu", "of"))
    mu = uncertainty.get("mu")
    stated = None if mu is None else _number(mu, "uncertainty", where, 0.0, MU.upper)
    source = _mapping(given.get("source"), where, "source", _SOURCE)
    held_out = given.get("held_out")
    card = Card(
        name=name,
        basis=str(basis),
        keywords=tuple(keywords),
        law=law,
        constants=constants,
        domain=domain,
        uncertainty=stated,
        uncertainty_of=_text(uncertainty, "of", f"{where}: uncertainty"),
        source={k: _text(source, k, f"{where}: source") for k in _SOURCE},
        held_out=None if held_out is None else _held_out(held_out, where),
        **texts,
    )
    if card.basis == "measured" and card.held_out is None:
        raise InputError(
            f"{where}: basis 'measured' without held_out, allowed: with the error on tests left out"
        )
    _check_law(card, where)
    return card


def _check_law(card: Card, where: str) -> None:
    """Refuse a law that leaves the limits of mu, or has none, somewhere in its domain."""
    try:
        model = card.model()
        unknown = [n for n in model.needed_loads if n not in card.domain]
        if unknown:
            raise InputError(
                f"the law depends on {unknown[0]!r}, allowed: loads whose range stands in the domain"
            )
        loads = np.vstack([card.sample(400), _corners(card)])
        with np.errstate(all="ignore"):
            mu = model.predict(loads)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    if not np.isfinite(mu).all() or mu.max() >= MU.upper:
        at = loads[int(np.argmax(~np.isfinite(mu) | (mu >= MU.upper)))].tolist()
        raise InputError(f"{where}: mu is no number below {MU.upper:g} at the loads {at}")


def _corners(card: Card) -> FloatArray:
    low, high = card.sample(1), card.sample(1)
    for k, n in enumerate(LOAD_NAMES):
        if n in card.domain:
            low[0, k], high[0, k] = card.domain[n]
    return np.vstack([np.where(np.array(c) == 0, low, high) for c in np.ndindex(*(2,) * len(LOAD_NAMES))])


def _domain(given: object, where: str) -> dict[str, tuple[float, float]]:
    found = {}
    for name, limits in _mapping(given, where, "domain", LOAD_NAMES).items():
        if not isinstance(limits, list) or len(limits) != 2:
            raise InputError(f"{where}: domain of {name!r} is {limits!r:.60}, allowed: [lower, upper]")
        q = QUANTITIES[name]
        low, high = (_number(v, f"domain of {name!r}", where, q.lower, q.upper) for v in limits)
        if low > high:
            raise InputError(f"{where}: domain of {name!r} is {low:g} to {high:g}, allowed: lower <= upper")
        found[name] = (low, high)
    return found


def _held_out(given: object, where: str) -> HeldOut:
    entries = _mapping(given, where, "held_out", _HELD_OUT)
    place = f"{where}: held_out"
    errors = [_number(entries.get(k), k, place, 0.0, MU.upper) for k in ("rmse", "constant_rmse")]
    counts = [_number(entries.get(k), k, place, 1.0, 1e9) for k in ("tests", "points")]
    return HeldOut(errors[0], errors[1], int(counts[0]), int(counts[1]), _text(entries, "how", place))


def _mapping(given: object, where: str, what: str, allowed: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(given, dict):
        raise InputError(f"{where}: {what} is {given!r:.60}, allowed: keys {', '.join(allowed)}")
    for key in given:
        if key not in allowed:
            raise unknown_name(f"key of {what}", key, allowed, where)
    return given


def _text(given: Mapping[str, Any], key: str, where: str) -> str:
    if key not in given:
        raise InputError(f"{where}: {key!r} is missing; allowed: a text")
    value = given[key]
    if not isinstance(value, str) or not 0 < len(value.strip()) <= MAX_TEXT:
        raise InputError(f"{where}: {key} is {value!r:.60}, allowed: a text of at most {MAX_TEXT} characters")
    return " ".join(value.split())


def _number(value: object, what: str, where: str, lower: float = -1e300, upper: float = 1e300) -> float:
    if not is_number(value) or not lower <= value <= upper:
        raise InputError(f"{where}: {what} is {value!r:.60}, allowed: a number from {lower:g} to {upper:g}")
    return float(value)
