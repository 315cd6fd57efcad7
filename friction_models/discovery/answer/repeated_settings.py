"""How near to one another the tests lie that count as repeats, in words."""

from __future__ import annotations

from ...estimation.campaign.settings import SAME_SETTING
from ...estimation.noise.noise_floor import RepeatsNumbers


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
