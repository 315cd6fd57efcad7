"""When friction that follows the loads lags too far behind them: a sentence about long communication steps."""

from __future__ import annotations

#: Largest travel of the tools in a communication step without a word about the lag [mm].
LARGEST_TRAVEL = 0.2


def lag_warnings(travel: float, where: str) -> tuple[str, ...]:
    """Return a sentence where friction is asked too rarely; none otherwise.

    - `travel`: of the tools in a communication step [mm].
    - `where`: the run or its component, as the sentence begins.

    Examples
    --------
    >>> lag_warnings(0.1, "forward rod extrusion")
    ()
    >>> lag_warnings(0.5, "forward rod extrusion")[0][:65]
    'forward rod extrusion: the tools travel 0.5 mm in a communication'
    """
    if travel <= LARGEST_TRAVEL * (1.0 + 1e-9):
        return ()
    return (
        f"{where}: the tools travel {travel:.3g} mm in a communication step, and friction follows the loads one step "
        f"later; recommended: at most {LARGEST_TRAVEL:g} mm. While the force of a rod rose, it was seen to be off by up to "
        f"1 % at {LARGEST_TRAVEL:g} mm, 3.6 % at 0.5 mm and 18 % at 1 mm",
    )
