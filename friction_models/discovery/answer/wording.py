"""Words for the numbers of an answer, as every text has them."""

from __future__ import annotations

from collections.abc import Sequence

from ...common.wording import listed
from ...estimation.campaign.settings import SAME_SETTING
from ...estimation.noise.noise_floor import NoiseFloorNumbers, RepeatsNumbers
from .findings import ParameterValue

#: Numbers of mu below this are printed by their significant digits.
SMALL_MU = 1e-4


def p_text(value: float | None) -> str:
    """Return a p-value as one writes it.

    Examples
    --------
    >>> p_text(0.0123), p_text(0.0001), p_text(None)
    ('0.012', '< 0.001', '-')
    """
    if value is None:
        return "-"
    return "< 0.001" if value < 0.001 else f"{value:.3f}"


def mu_format(largest: float, decimals: int = 5) -> str:
    """Return the format of numbers of mu that stand together, by the largest: fixed decimals, which very small ones do not fill.

    Examples
    --------
    >>> f"{0.00763:{mu_format(0.00763)}}", f"{0.0:{mu_format(0.00763)}}", f"{3.21e-9:{mu_format(1e-8)}}"
    ('0.00763', '0.00000', '3.21e-09')
    """
    return ".2e" if 0.0 < largest < SMALL_MU else f".{decimals}f"


def confidence_text(confidence: float) -> str:
    """Return a confidence as every text has it.

    Examples
    --------
    >>> confidence_text(0.885), confidence_text(1.0)
    ('0.89', '1.00')
    """
    return f"{confidence:.2f}"


def in_hundred(confidence: float) -> str:
    """Return a confidence in hundredths, rounded as `confidence_text` rounds it: the two stand side by side.

    Examples
    --------
    >>> in_hundred(0.885), f"{100 * 0.885:.0f}"
    ('89', '88')
    """
    return f"{100 * float(confidence_text(confidence)):.0f}"


def meaning_of_numbers(confidence: float | None, p: float | None = None) -> str:
    """Return in plain words what the numbers behind a verdict mean; `p` where it stands there, too.

    Examples
    --------
    >>> meaning_of_numbers(0.5).partition(": ")[2]
    'about 50 in 100 such answers are right, judged by made-up data whose cause is known; what the tests cannot show lowers it.'
    >>> "some effect look this good in 0.2 % of data sets" in meaning_of_numbers(0.5, 0.002)
    True
    >>> meaning_of_numbers(None)
    ''
    """
    if confidence is None:
        return ""
    sure = (
        f"Confidence {confidence_text(confidence)}: about {in_hundred(confidence)} in 100 such answers are right, judged by made-up data whose cause is "
        "known; what the tests cannot show lowers it."
    )
    if p is None:
        return sure
    return (
        f"Two numbers, two questions. Is anything missing? p {'' if p < 0.001 else '= '}{p_text(p)}: if nothing were, chance alone would make "
        f"some effect look this good in {'less than 0.1' if p < 0.001 else f'{100 * p:.2g}'} % of data sets. Is this the right answer? {sure}"
    )


def parts_of_floor(floor: NoiseFloorNumbers) -> str:
    """Return the shares of a noise floor in words; empty where its parts, which were estimated beside the effect that leads, are far
    from adding up to what unseen tests leave.

    Examples
    --------
    >>> found = {"sensor": 0.002, "test": 0.003, "drift": 0.0, "total": 0.0032, "interval": [0.003, 0.005]}
    >>> parts_of_floor({**found, "shares": {"test": 0.92, "drift": 0.0, "sensor": 0.08}})
    'of its square 92 % test scatter, 0 % drift, 8 % sensor, which has 0.00200 a point'
    >>> parts_of_floor(found)
    ''
    """
    shares = floor.get("shares")
    if not shares:
        return ""
    said = ", ".join(
        f"{100.0 * shares[part]:.0f} % {name}"
        for part, name in (("test", "test scatter"), ("drift", "drift"), ("sensor", "sensor"))
    )
    return f"of its square {said}, which has {floor['sensor']:{mu_format(floor['total'])}} a point"


def interval_text(value: ParameterValue) -> str:
    """Return the 95 % interval of a fitted parameter, in words where it is not known.

    Examples
    --------
    >>> interval_text({"value": 13.7, "unit": "mm/s", "interval": [9.0, 21.0]})
    '9 to 21'
    >>> interval_text({"value": 13.7, "unit": "mm/s", "interval": [1.25, 1200.0], "not_known": True})
    'not known: 1.25 to 1200 was sought'
    >>> interval_text({"value": 1.0, "unit": "1"})
    'not fitted'
    """
    if "interval" not in value:
        return "not fitted"
    low, high = (f"{float(f'{edge:.3g}'):g}" for edge in value["interval"])
    return f"not known: {low} to {high} was sought" if value.get("not_known") else f"{low} to {high}"


def told_by(separates: Sequence[str]) -> str:
    """Return what a proposed test tells: effects apart, or what one does, or friction where nothing is missing, in a gap of the plan.

    Examples
    --------
    >>> for names in (["stribeck", "hersey"], ["stribeck"], []):
    ...     print(told_by(names))
    stribeck from hersey
    what stribeck does between the levels of the plan
    what friction does between the levels of the plan
    """
    if len(separates) > 1:
        return " from ".join(separates)
    return f"what {next(iter(separates), 'friction')} does between the levels of the plan"


def about_next_tests(verdict: str) -> str:
    """Return for what answer tests are proposed, where that is not the one that is given.

    Examples
    --------
    >>> about_next_tests("explained")
    ''
    """
    if verdict != "unknown_structure":
        return ""
    return "no effect of the catalogue explains it as the tests stand; these tell whether one does after all, and which"


def settings_text(repeats: RepeatsNumbers) -> str:
    """Return which tests are repeats, in words.

    Examples
    --------
    >>> numbers = {"settings": 14, "tests": 62, "scatter": 0.03, "interval": [0.02, 0.04], "p_value": 0.001}
    >>> settings_text({**numbers, "exact": False})
    '62 tests at 14 settings that agree within 3 % of the range of their loads'
    >>> settings_text({**numbers, "exact": True})
    '62 tests at 14 repeated settings'
    """
    near = repeats.get("exact") is False
    settings = (
        f"settings that agree within {100 * SAME_SETTING:g} % of the range of their loads"
        if near
        else "repeated settings"
    )
    return f"{repeats['tests']} tests at {repeats['settings']} {settings}"


def floor_source(floor: NoiseFloorNumbers, named: Sequence[str] = ()) -> str:
    """Return what identifies a noise floor, in words, beside the effects that are named; empty for files that do not say it.

    Examples
    --------
    >>> found = {"sensor": 0.002, "test": 0.003, "drift": 0.0, "total": 0.0036, "interval": [0.003, 0.005]}
    >>> floor_source({**found, "source": "unknown"})
    'cannot be known from so few tests'
    >>> floor_source({**found, "source": "model", "hardly_better": True})
    'flexible curves predict unseen tests hardly better than the model: too little to count'
    """
    if (repeats := floor.get("repeats")) is not None:
        scatter = f"{settings_text(repeats)} scatter by {repeats['scatter']:{mu_format(repeats['scatter'])}}"
        if floor.get("source") == "repeats":
            return f"from repeats: {scatter}"
    beside = f" with {listed(named)}" if named else ""
    model = f"no flexible curve predicts unseen tests better than the model{beside}"
    if floor.get("hardly_better"):
        model = (
            f"flexible curves predict unseen tests hardly better than the model{beside}: too little to count"
        )
    said = {
        "reference": "what flexible curves over loads and metadata do not predict of unseen tests",
        "level": "what a line of their own does not predict of the tests of one level, nor the model of all others",
        "terms": "what no empirical term beside what would be named predicts of unseen tests",
        "model": model,
        "unknown": "cannot be known from so few tests",
    }.get(floor.get("source", ""), "")
    return f"{said}; {scatter}" if repeats is not None else said
