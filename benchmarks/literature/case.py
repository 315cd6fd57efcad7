"""What one case of the benchmark is."""

from __future__ import annotations

from dataclasses import dataclass

KINDS = ("null", "single", "pair", "triple", "outside", "mixed", "hidden_group", "thin", "foreign")


@dataclass(frozen=True)
class Case:
    """One campaign to make and to diagnose.

    Attributes
    ----------
    id : str
        Unique name.
    kind : str
        One of `KINDS`. ``mixed`` is a catalogue law and one outside it; ``hidden_group`` a factor nobody recorded.
    laws : tuple of str
        Keys of the hidden laws.
    recipe : str
        Noise recipe.
    seed : int
        Seed of everything random in the campaign.
    ratio : tuple of float
        Range from which the size of each law against the scatter is drawn (log-uniform).
    domain : str
        Load ranges.
    style : str
        For ``thin``: style of the plan. For ``foreign``: what is unusual about the table.
    points : int
        Points a test.
    n_heldout : int
        Held-out tests.
    """

    id: str
    kind: str
    laws: tuple[str, ...]
    recipe: str
    seed: int
    ratio: tuple[float, float] = (0.7, 3.0)
    domain: str = "sliding_compression"
    style: str = ""
    points: int = 120
    n_heldout: int = 24

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"kind {self.kind!r} is unknown; use one of {KINDS}")
        if not 20 <= self.points <= 550:
            raise ValueError(f"points = {self.points} is outside 20 to 550")
