"""Further tests with the lubricant of a virtual campaign, such as those that a diagnosis proposes."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

import pandas as pd

from ..ingest.raw_campaign import RawCampaign
from ..records.cells import Cell
from .campaign import Campaign
from .heat.bodies import LabHeat
from .law import TrueLaw, load_truth
from .rig.instruments import Faults, Instruments
from .rig.specimen import Rig


def run_protocol(
    source: Campaign | RawCampaign | str | os.PathLike[str],
    rows: pd.DataFrame | Sequence[Mapping[str, Cell]] | str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    seed: int = 1,
    jobs: int | None = None,
) -> RawCampaign:
    """Carry out further tests with the lubricant of an earlier virtual campaign, on its rig with its faults.

    Parameters
    ----------
    source : Campaign, RawCampaign or path-like
        The campaign, or the folder it was written to.
    rows : DataFrame, sequence of mapping, or path-like
        Rows of a plan, as `plans.complete_plan` takes them; `diagnose` proposes such rows.
    out : path-like, optional
        Folder to write; a temporary folder by default.
    seed : int
        Of specimens and noise; another one than the campaign's gives new specimens.
    jobs : int, optional
        Processes; all cores by default.

    Raises
    ------
    InputError
        No truth there, or rows that cannot be tested.
    """
    if not isinstance(rows, pd.DataFrame | str | os.PathLike):
        rows = pd.DataFrame(list(rows))
    if isinstance(source, Campaign):
        law, rig, instruments = source.true_law, source.true_rig, source.sensors
        lubricant, cache, faults = source.lubricant, source.cache, source.true_faults
    else:
        content = load_truth(source.folder if isinstance(source, RawCampaign) else source)[0]
        law, cache = TrueLaw.from_dict(content["law"]), None
        lubricant = law.lubricant
        rig = Rig(**{**content["rig"], "thermal": LabHeat.from_dict(content["rig"]["thermal"])})
        instruments = Instruments(**content["instruments"])
        wrong = content.get("faults")
        faults = None if wrong is None else Faults(**{**wrong, "tests": tuple(wrong["tests"])})
    if faults is not None and faults.tests:
        faults = None  # what happened to single tests does not happen to others
    campaign = Campaign(
        rows, None, seed, rig, instruments, cache, lubricant=lubricant, faults=faults, law=law
    )
    return campaign.run(out, jobs)
