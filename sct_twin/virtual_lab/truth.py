"""The truth of a virtual campaign: kept in files of its own that no training or diagnosis reads."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common import InputError, write_json
from friction_models.common.files import read_json
from friction_models.loads import FloatArray

from ..twin.contact_temperature import ThermalBody, ThermalSettings
from .rig.specimen import Rig

TRUTH_JSON, TRUTH_NPZ = "truth.json", "truth.npz"


def write_truth(
    source: Path, folder: Path, ids: list[str], about: Mapping[str, Any]
) -> dict[str, dict[str, float]]:
    """Gather the truth of single tests in `source` into the two truth files of a campaign folder.

    Returns what each specimen, cell and lubricant film was.
    """
    truth: dict[str, FloatArray] = {}
    scatter: dict[str, dict[str, float]] = {}
    for test_id in ids:
        with np.load(source / f"{test_id}.npz", allow_pickle=False) as stored:
            scatter[test_id] = {n[8:]: float(stored[n]) for n in stored.files if n.startswith("scatter/")}
            truth |= {f"{test_id}/{n}": stored[n] for n in stored.files if not n.startswith("scatter/")}
    np.savez_compressed(folder / TRUTH_NPZ, **truth)  # type: ignore[arg-type]
    write_json(folder / TRUTH_JSON, {"synthetic": True, **about, "tests": scatter})
    return scatter


def load_truth(folder: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, dict[str, FloatArray]]]:
    """Read the truth of a campaign: (law and rig, arrays by test). For checks of the laboratory only.

    Raises
    ------
    InputError
        The folder holds no truth.
    """
    path = Path(folder)
    if not (path / TRUTH_JSON).is_file() or not (path / TRUTH_NPZ).is_file():
        raise InputError(
            f"{path}: no {TRUTH_JSON} and {TRUTH_NPZ}; allowed: a folder the virtual laboratory wrote"
        )
    content = read_json(path / TRUTH_JSON)
    tests: dict[str, dict[str, FloatArray]] = {}
    with np.load(path / TRUTH_NPZ, allow_pickle=False) as stored:
        for key in stored.files:
            test_id, _, name = key.partition("/")
            tests.setdefault(test_id, {})[name] = stored[key]
    return content, tests


def rig_from(content: Mapping[str, Any]) -> Rig:
    """Return the rig that `truth.json` describes."""
    thermal = content["thermal"]
    bodies = {name: ThermalBody(**thermal[name]) for name in ("plate", "specimen")}
    return Rig(**{**content, "thermal": ThermalSettings(**{**thermal, **bodies})})
