"""Why the effect that is named first need not be the first of the ranking."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...effects.base import Effect
from ...estimation.search.scan import Fit

#: Effects above the named one that are tried in its place: each takes a refit.
MOST = 3
#: An error below this share of another is better, not just no worse.
BETTER = 0.95


def listed(names: Sequence[str]) -> str:
    """Return names as one says them.

    Examples
    --------
    >>> listed(["a"]), listed(["a", "b", "c"])
    ('a', 'a, b and c')
    """
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def why_not_first(
    chosen: Sequence[Fit],
    ranking: Sequence[Fit],
    alike: Sequence[str],
    error: Callable[[Sequence[Effect]], float],
) -> str:
    """Return in a sentence why the first of the `chosen` effects is named though others are ranked above it; empty where none is.

    `error` returns the RMS of mu on tests that no fit saw, with the effects that are added; it is asked once for each of the first `MOST` effects above.
    What is `alike` the tests cannot tell from the first one. Nothing but these errors is claimed: other rules may have decided, too.
    """
    places = [f.name for f in ranking]
    if not chosen or chosen[0].name not in places[1:]:
        return ""
    first, *others = chosen
    beside = [f.effect for f in others]
    own, without = error([first.effect, *beside]), error(beside)
    place = places.index(first.name)
    worse: dict[str, float] = {}
    as_good: dict[str, float] = {}
    named: dict[str, float] = {}
    for f in ranking[: min(place, MOST)]:
        if f.name in {g.name for g in others}:
            named[f.name] = error([g.effect for g in chosen if g.name != f.name])
        else:
            left = error([f.effect, *beside])
            (worse if left > own else as_good)[f.name] = left
    decide = ", which decide over names," if worse or named else ""
    said = [
        f"{first.name} is named first though it is number {place + 1} of the ranking: on tests that no fit saw{decide} the error (rms of mu) "
        f"is {own:.3g} with it{f' and {listed([f.name for f in others])}' if others else ''}, {without:.3g} without it"
    ]
    if worse:
        said.append(f"and with {listed(list(worse))} in its place {_from(worse)}")
    said += [f"and without {name}, which is named as well, {left:.3g}" for name, left in named.items()]
    if as_good:
        rivals = [name for name in as_good if name in alike]
        apart = f" ({listed(rivals)}: not told apart)" if rivals else ""
        how = "better" if max(as_good.values()) < BETTER * own else "no worse"
        said.append(f"but {listed(list(as_good))} in its place would be {how}{apart}: {_from(as_good)}")
    return ", ".join(said) + "."


def _from(errors: dict[str, float]) -> str:
    low, high = min(errors.values()), max(errors.values())
    return f"{low:.3g}" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g} to {high:.3g}"
