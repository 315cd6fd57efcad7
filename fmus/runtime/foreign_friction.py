"""Friction FMUs of other generators: which variables take the loads, as a file of names says or their own names do."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path

from friction_models.common import InputError

from ..archive.content import read_archive
from .fixed_friction import MODEL, FmuModel
from .fmu_files import describe
from .friction_names import Entry, FrictionNames, entries_by_model


def friction_model(path: str | os.PathLike[str], entry: Entry | None = None) -> FmuModel:
    """Open any friction FMU as a model; `entry` is its entry in a file of names (`read_names`).

    Raises InputError: not an FMU, or one whose variables are neither those of the contract nor named by `entry`.
    """
    if entry is None:
        with _hinted():
            model = FmuModel(path)
        if model.source is not None:
            return model
    return FmuModel(path, names=FrictionNames.of(describe(path), entry or {}))


@contextmanager
def _hinted() -> Iterator[None]:
    """Let an error about variables say what helps."""
    try:
        yield
    except InputError as error:
        if not any(word in str(error) for word in ("variable", "output for")):
            raise
        raise InputError(
            f"{error}; for an FMU with other variables --names FILE.yaml says which takes which load"
        ) from None


@dataclass(frozen=True)
class GivenNames:
    """What a file of names says of the models of a command line."""

    file: Path | None = None  #: None where there is no such file.
    #: By model (`friction_names.entries_by_model`).
    entries: Mapping[str, Entry] = field(default_factory=dict)

    @classmethod
    def read(cls, models: Sequence[str], file: Path | None) -> GivenNames:
        """Read the file, if there is one.

        Raises InputError: what `entries_by_model` refuses.
        """
        return cls() if file is None else cls(file, entries_by_model(models, file))

    def open(self, model: str) -> FmuModel:
        """Return the friction FMU of that name as `friction_model` does; errors in an entry name the file."""
        with self._blamed(model):
            return friction_model(model, self.entries.get(model))

    def foreign(self, model: str) -> FrictionNames | None:
        """Return what `foreign_names` returns; errors in an entry name the file."""
        with self._blamed(model):
            return foreign_names(model, self.entries.get(model))

    @contextmanager
    def _blamed(self, model: str) -> Iterator[None]:
        try:
            yield
        except InputError as error:
            if model not in self.entries:
                raise
            raise InputError(f"{self.file}: {error}") from None


def foreign_names(path: str | os.PathLike[str], entry: Entry | None = None) -> FrictionNames | None:
    """Return the variables of a friction FMU that others made; None for one of ours, which needs no care.

    Raises InputError: what `FrictionNames.of` refuses.
    """
    described = describe(path)
    if entry is None and MODEL in read_archive(path):
        return None
    with _hinted() if entry is None else nullcontext():
        return FrictionNames.of(described, entry or {})
