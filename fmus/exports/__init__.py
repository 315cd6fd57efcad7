"""Friction models for forming codes that take subroutines or tables instead of FMUs.

==========  ==============================================================================
``c``       one header and one C99 source with the FMU's own formulas
``ufric``   user subroutine UFRIC of Marc / Simufact Forming: Fortran around that C
``vfric``   user subroutines VFRIC and VFRICTION of Abaqus/Explicit: Fortran around that C
``deform``  user routines USRBCC and USRUPD of DEFORM-2D: Fortran around that C
``lsdyna``  user friction USRFRC of LS-DYNA: Fortran around that C
``qform``   user subroutine FrictionStress of QForm, in Lua
``abaqus``  native table of *FRICTION of Abaqus, with the error that remains
``radioss``  coefficients of the friction formulas of OpenRadioss, with the error that remains
``calculix``  the one coefficient that CalculiX takes, with the error that remains
``table``   mu over a grid of loads, with its measured interpolation error
==========  ==============================================================================

`subroutines` holds the hosts that take code, `numbers` those that take a table or coefficients; both use the modules beside them.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from friction_models.common import InputError, check_folder, unknown_name
from friction_models.common.folders import EXPORT

from ..interface.friction_source import FrictionSource

if TYPE_CHECKING:
    from .common import Files

#: What `_makers` knows; to be had without importing it.
TARGETS = ("c", "ufric", "vfric", "deform", "lsdyna", "qform", "abaqus", "radioss", "calculix", "table")

__all__ = ["TARGETS", "export"]


def export(source: FrictionSource, path: str | os.PathLike[str], target: str, **options: Any) -> Path:
    """Write a friction model for a code that does not load FMUs.

    Parameters
    ----------
    source : FrictionSource
        What `fmus.source.reading.read_source` returns.
    path : path-like
        Folder to write; one written by an earlier export is replaced, any other that holds files is refused.
    target : str
        One of `TARGETS`; see the module.
    **options
        `name` (all targets but ``table``): first part of the C names, from the model's name by default.
        For ``table`` see `fmus.exports.numbers.table_target.table_files`.

    Returns
    -------
    Path
        `path`. The same model gives the same files.

    Raises
    ------
    InputError
        An unknown target or option, a folder that is no export (`check_folder`), a graph that is not translated, a model
        that cannot be tabulated.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     folder = export(read_source(ConstantFriction(mu=0.1)), Path(place) / "law", "c", name="law")
    ...     sorted(p.name for p in folder.iterdir())
    ['LICENSE.txt', 'README.txt', 'card.json', 'export.json', 'law_friction.c', 'law_friction.h', 'model.onnx', 'selftest.c']
    """
    if target not in TARGETS:
        raise unknown_name("export target", target, TARGETS)
    if source.foreign is not None:
        raise InputError(
            f"{source.where}: this graph runs in Python only and cannot be exported; allowed: --target python"
        )
    from .common import checked_options, write_folder

    check_folder(path, EXPORT)
    files_of, allowed = _makers()[target]
    return write_folder(path, target, files_of(source, **checked_options(target, options, allowed)))


def _makers() -> dict[str, tuple[Callable[..., Files], Sequence[str]]]:
    """Return what makes the files of each target, and the options it takes."""
    from .numbers import abaqus_target, fitted_target, table_target
    from .subroutines import c_target, deform_target, lsdyna_target, qform_target, ufric_target, vfric_target

    def around_c(
        target: str, files_of: Callable[..., Files], *own: str
    ) -> tuple[Callable[..., Files], Sequence[str]]:
        return functools.partial(_around_c, target, files_of), ("name", *own)

    return {
        "c": around_c("c", c_target.c_files),
        "ufric": around_c("ufric", ufric_target.ufric_files),
        "vfric": around_c("vfric", vfric_target.vfric_files),
        "deform": around_c("deform", deform_target.deform_files, "units"),
        "lsdyna": around_c("lsdyna", lsdyna_target.lsdyna_files, "units", "temperature", "thermal"),
        "qform": (qform_target.qform_files, qform_target.OPTIONS),
        "abaqus": (abaqus_target.abaqus_files, abaqus_target.OPTIONS),
        "radioss": (fitted_target.radioss_files, fitted_target.OPTIONS),
        "calculix": (fitted_target.calculix_files, (*fitted_target.OPTIONS, "slip")),
        "table": (table_target.table_files, table_target.OPTIONS),
    }


def _around_c(
    target: str,
    files_of: Callable[..., Files],
    source: FrictionSource,
    name: str | None = None,
    **options: object,
) -> Files:
    """Return the files of an export in C, or in Fortran around it; `name` is the first part of the C names."""
    from .common import c_prefix, documents, template
    from .subroutines.c_target import c_sources, c_values

    prefix = c_prefix(source, name)
    values = c_values(source, prefix)
    values["FORTRAN_MODEL"] = template("model.f", values)
    return {
        **c_sources(source, values),
        **files_of(source, prefix, values, **options),
        "README.txt": template(f"readme_{target}.txt", values),
        **documents(source),
    }
