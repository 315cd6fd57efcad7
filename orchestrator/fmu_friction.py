"""A friction FMU used as a friction model: a fixed law that is evaluated on data, never refitted."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from friction_models.domain import Domain
from friction_models.loads import LOADS, FloatArray, InputError, TriboLoads

from .fmu_files import FmuDescription, Variable, describe
from .instance import Instance, Port


class FmuFriction:
    """The law inside a friction FMU, with the interface of a friction model.

    Where the data has time, every test is stepped through from a fresh state, so that an FMU with memory
    gives what it would give in a simulation. Loads outside the trained domain are clamped or not, as the
    FMU's own `clamp_to_domain` says.

    Parameters
    ----------
    path : path-like
        An FMI 2.0 co-simulation FMU with the inputs ``v_rel T sigma_n sd psi`` (or ``v_rel[1]``..) and
        the output ``mu``.

    Raises
    ------
    InputError
        Not an FMU, or not one with these variables and units.
    """

    family = "fmu"
    is_fitted = True

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.description: FmuDescription = describe(self.path)
        self._loads, self._mu = friction_variables(self.description)
        self.nodes = len(self._mu)

    @property
    def domain(self) -> Domain:
        """The trained domain that the FMU carries with its ONNX file; the physical limits without one."""
        return _domain(self.path)

    def formula_text(self) -> str:
        """Name of the model inside."""
        return f"{self.description.raw.modelName} ({self.path.name})"

    def predict(self, loads: TriboLoads | npt.ArrayLike) -> FloatArray:
        """Return mu at `loads`, shape (n,).

        Raises
        ------
        InputError
            Loads that are not finite or outside the physical limits.
        SimulationError
            The FMU refused a value.
        """
        points = loads if isinstance(loads, TriboLoads) else TriboLoads.from_array(loads)
        with self._instance() as instance:
            if points.t is None:
                return self._in_batches(instance, points.as_array())
            parts = [self._through(instance, points, part) for part in points.segments()]
        return np.concatenate(parts)

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> FloatArray:
        """Return mu for a table with the columns of the contract."""
        return self.predict(TriboLoads.from_frame(data, tests))

    @contextmanager
    def _instance(self) -> Iterator[Instance]:
        folder = Path(tempfile.mkdtemp(prefix="tribofmu-"))
        try:
            with Instance(self.path.stem, self.description, folder) as instance:
                instance.initialize([], stop_time=1.0)
                yield instance
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _in_batches(self, instance: Instance, array: FloatArray) -> FloatArray:
        inputs, outputs = Port([v for load in self._loads for v in load]), Port(self._mu)
        mu = np.empty(len(array))
        for first in range(0, len(array), self.nodes):
            rows = np.minimum(np.arange(first, first + self.nodes), len(array) - 1)
            inputs.values[:] = array[rows].T.ravel()
            instance.write(inputs)
            instance.read(outputs)
            count = min(self.nodes, len(array) - first)
            mu[first : first + count] = outputs.values[:count]
        return mu

    def _through(self, instance: Instance, points: TriboLoads, part: slice) -> FloatArray:
        """Step through one test with the first node; the first point is read without a step."""
        assert points.t is not None
        inputs, outputs = Port([load[0] for load in self._loads]), Port(self._mu[:1])
        array, time = points.as_array()[part], points.t[part] - points.t[part][0]
        mu = np.empty(len(array))
        instance.reset()
        instance.initialize([], stop_time=float(time[-1]) + 1.0)
        for k, row in enumerate(array):
            inputs.values[:] = row
            if k == 0:
                instance.write(inputs)
                instance.read(outputs)
            else:
                instance.step(inputs, outputs, float(time[k - 1]), float(time[k] - time[k - 1]))
            mu[k] = outputs.values[0]
        return mu


def friction_variables(description: FmuDescription) -> tuple[list[list[Variable]], list[Variable]]:
    """Return the five load inputs (each a list of nodes) and the outputs mu of a friction FMU.

    Raises
    ------
    InputError
        A variable is missing, not an input, or in another unit: not a friction FMU.
    """
    problems: list[str] = []
    loads: list[list[Variable]] = []
    for quantity in LOADS:
        elements = description.arrays.get(quantity.name)
        if elements is None or elements[0].causality != "input":
            problems.append(f"the input {quantity.name!r} is missing")
        elif elements[0].unit not in {quantity.unit, "", "-"}:
            problems.append(
                f"the input {quantity.name!r} is in {elements[0].unit!r}, allowed: {quantity.unit!r}"
            )
        else:
            loads.append(elements)
    mu = description.arrays.get("mu")
    if mu is None or mu[0].causality != "output":
        problems.append("the output 'mu' is missing")
    if problems or mu is None:
        raise _no_friction(description, problems)
    if {len(load) for load in loads} != {len(mu)}:
        raise _no_friction(description, ["loads and mu have different numbers of nodes"])
    return loads, mu


def _no_friction(description: FmuDescription, problems: Sequence[str]) -> InputError:
    names = [n for n, v in description.arrays.items() if v[0].causality in {"input", "output"}]
    return InputError(
        f"{description.path}: not a friction FMU: {'; '.join(problems)}; its inputs and outputs: {', '.join(names) or 'none'}"
    )


def _domain(path: Path) -> Domain:
    """Read the domain from the metadata of the ONNX file inside the archive."""
    import json
    import zipfile

    import onnx

    with zipfile.ZipFile(path) as archive:
        names: Sequence[str] = [n for n in archive.namelist() if n.endswith(".onnx")]
        if not names:
            return Domain.physical()
        try:
            model = onnx.load_from_string(archive.read(names[0]))
            metadata = {item.key: item.value for item in model.metadata_props}
            return Domain.from_dict(json.loads(metadata["tribofmu.domain"]))
        except (KeyError, ValueError, InputError):
            return Domain.physical()
        except Exception as error:
            raise InputError(f"{path}: {names[0]} cannot be read ({type(error).__name__})") from None
