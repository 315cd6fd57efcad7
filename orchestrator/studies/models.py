"""Jobs that train a friction model on a data set and pack it; several studies share their results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from friction_models.common import InputError

from ..jobs.graph import Job
from ..jobs.job import Files, Inputs, Needs

if TYPE_CHECKING:
    from friction_models.loads import DataSet

#: The five advanced models, simplest first, and the two constants from the literature.
ADVANCED = ("linear", "polynomial", "power_law", "gradient_boosting", "ffnn")
CONSTANTS = (0.04, 0.08)
#: Expected CPU time of training and packing [s], for estimates of a whole campaign.
SECONDS = {"gradient_boosting": 5.0, "ffnn": 20.0}
USUAL_SECONDS = 3.0
#: Folder and file in the result of a job.
MODEL, FMU = "model", "friction.fmu"


class TrainedModel(TypedDict):
    """Result of a job of `model_job`."""

    family: str
    model: str  # folder in that of the job
    fmu: str  # file in it
    domain: dict[str, list[float] | None]
    points: int  # that it was trained on
    tests: int  # that it was trained on
    mae_test: float | None  # on held-out tests, None without any
    rmse_test: float | None
    synthetic: bool


def model_job(
    family: str,
    data: str | Path | None = None,
    *,
    name: str | None = None,
    parameters: Mapping[str, object] | None = None,
    tests: Sequence[str] | None = None,
) -> Job:
    """Return the job that trains one model, called ``model-FAMILY-DATA`` by default.

    `data` is the name of the job whose folder holds the data set (its value ``dataset`` says in which folder), or
    the ``points.csv`` (or Parquet) file of one, whose ``tests.csv`` and ``dataset.json`` lie beside it; the family
    ``constant`` with ``parameters={"mu": 0.08}`` needs none. Without `tests` the model is trained on those with the role
    ``train``, or on all where there is none.
    """
    files: dict[str, Path] = {}
    needs: tuple[str, ...] = ()
    label = ""
    if isinstance(data, Path):
        files = data_files(data)
        label = data.name if data.is_dir() else data.parent.name
    elif data is not None:
        needs, label = (data,), data
    inputs: dict[str, object] = {"family": family, "parameters": dict(parameters or {})}
    if tests is not None:
        inputs["tests"] = list(tests)
    seconds = SECONDS.get(family, USUAL_SECONDS)
    return Job(name or model_name(family, label), f"{__name__}:train_model", inputs, files, needs, seconds)


def model_name(family: str, data: str) -> str:
    """Return the name of the job that trains a family on a data set."""
    return f"model-{family}-{data}" if data else f"model-{family}"


def constant_job(mu: float) -> Job:
    """Return the job that packs a constant coefficient of friction.

    Examples
    --------
    >>> constant_job(0.08).inputs
    {'family': 'constant', 'parameters': {'mu': 0.08}}
    """
    return model_job("constant", name=f"model-constant-{mu:g}", parameters={"mu": mu})


def data_files(data: Path) -> dict[str, Path]:
    """Return the files of a data set by the names under which `train_model` looks for them."""
    if data.is_file():
        return {"points": data}
    from friction_models.loads.dataset import points_file

    beside = {"tests": data / "tests.csv", "info": data / "dataset.json"}
    return {"points": points_file(data)} | {key: file for key, file in beside.items() if file.is_file()}


def load_data(files: Files, needs: Needs) -> DataSet:
    """Return the data set that a job was given: by files, or as the result of another job."""
    from friction_models.loads import DataSet

    if "points" in files:
        points = files["points"]
        if "tests" in files and files["tests"].parent == points.parent:
            return DataSet.load(points.parent)
        return DataSet.load(points, files.get("tests"))
    (result,) = needs.values()
    return DataSet.load(result.folder / str(result.values.get("dataset", "dataset")))


def train_model(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> TrainedModel:
    """Train a model, measure it on held-out tests, save it and pack it as an FMU of FMI 3.0 for any number of points."""
    from fmus import pack
    from friction_models.families.registry import make_model
    from friction_models.training import error_measures

    family = str(inputs["family"])
    model = make_model(family, **inputs.get("parameters", {}))
    made: TrainedModel = {
        "family": family,
        "model": MODEL,
        "fmu": FMU,
        "domain": {},
        "points": 0,
        "tests": 0,
        "mae_test": None,
        "rmse_test": None,
        "synthetic": False,
    }
    if files or needs:
        data = load_data(files, needs)
        training = data.select("train")
        if not len(training.points):
            training = data
        points = training.points
        if "tests" in inputs:
            points = points[points["test_id"].isin(inputs["tests"])].reset_index(drop=True)
            if not len(points):
                raise InputError(
                    f"{family}: none of the tests {inputs['tests'][:5]} is in the data, allowed: some of them"
                )
        model.fit_frame(points, training.tests, data.info)
        made["points"] = len(points)
        made["tests"] = int(points["test_id"].nunique())
        made["synthetic"] = bool(data.synthetic)
        roles = data.tests["role"].astype(str) if data.tests is not None and "role" in data.tests else ()
        if "test" in set(roles):  # without roles all tests were trained on, and nothing is held out
            test = data.select("test")
            measures = error_measures(
                test.points["mu"].to_numpy(),
                np.asarray(model.predict_frame(test.points, test.tests), dtype=np.float64),
            )
            model.record_errors("test", measures)
            made["mae_test"], made["rmse_test"] = measures["mae"], measures["rmse"]
    model.save(folder / MODEL)
    pack(model, folder / FMU, fmi="3.0", arrays=True)
    made["domain"] = model.domain.to_dict()
    return made
