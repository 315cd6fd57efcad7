"""Why the first of the ranking need not be the effect that is named first, or named at all."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...common.wording import listed
from ...effects.base import Effect
from ...estimation.search.scan import Fit
from ..judge.closest import Closest

#: An error below this share of another is better, not just no worse.
BETTER = 0.95


def why_not_first(
    chosen: Sequence[Fit],
    ranking: Sequence[Fit],
    alike: Sequence[str],
    error: Callable[[Sequence[Effect]], float],
) -> str:
    """Return in a sentence why the first of the `chosen` effects is named and not that of the ranking; empty where they are the same.

    `error` returns the RMS of mu on tests that no fit saw, with the effects that are added: each takes a refit. What is `alike` the
    tests cannot tell from the first one. Nothing but these errors is claimed: other rules may have decided, too.
    """
    places = [f.name for f in ranking]
    if not chosen or chosen[0].name not in places[1:]:
        return ""
    (first, *others), top = chosen, ranking[0]
    beside = [f.effect for f in others]
    own, without = error([first.effect, *beside]), error(beside)
    also = top.name in {f.name for f in others}
    left = error([f.effect for f in chosen if f.name != top.name] if also else [top.effect, *beside])
    decide = ", which decide over names," if also or left > own else ""
    joined = listed(f.name for f in others)
    said = (
        f"{first.name} is named first though it is number {places.index(first.name) + 1} of the ranking: on tests that no fit saw"
        f"{decide} the error (rms of mu) is {own:.3g} with it{f' and {joined}' if joined else ''}, {without:.3g} without it, "
    )
    if also:
        return f"{said}and without {top.name}, which is named as well, {left:.3g}."
    if left > own:
        return f"{said}and with {top.name} in its place {left:.3g}."
    how = "better" if left < BETTER * own else "no worse"
    apart = " (not told apart)" if top.name in alike else ""
    return f"{said}but {top.name} in its place would be {how}{apart}: {left:.3g}."


def comes_closest(found: Closest) -> str:
    """Return what an effect would do where nothing is named.

    Examples
    --------
    >>> comes_closest(Closest("hersey", 0.0068, 0.0044, 0.0035, fault=False))[:94]
    'hersey comes closest: refine --add hersey lowers the rms error on unseen tests from 0.0068 to '
    """
    return (
        f"{found.name} comes closest: refine --add {found.name} lowers the rms error on unseen tests from {found.before:.3g} to {found.after:.3g} "
        f"({found.reachable:.3g} is known to be reachable{', so it may be this effect all the same' if found.explains else ''}). "
        "It is not named, for one of these reasons: "
        + (
            "it is larger than such a fault is, "
            if found.fault
            else "mu does not run the way this effect must, "
        )
        + "what is missing has another form or fewer loads, or more than this is missing"
    )
