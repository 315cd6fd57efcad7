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

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from friction_models.common import InputError, check_folder, unknown_name
from friction_models.common.folders import EXPORT

from ..interface.friction_source import FrictionSource

if TYPE_CHECKING:
    from .common import Files

#: Targets around the C text, and those that a host takes as Lua or as numbers.
C_TARGETS = ("c", "ufric", "vfric", "deform", "lsdyna")
OTHER_TARGETS = ("qform", "abaqus", "radioss", "calculix", "table")
TARGETS = (*C_TARGETS, *OTHER_TARGETS)
#: Options of the targets in C and Fortran, besides `name`.
SUBROUTINE_OPTIONS: dict[str, tuple[str, ...]] = {
    "deform": ("units",),
    "lsdyna": ("units", "temperature", "thermal"),
}

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
    if target in OTHER_TARGETS:
        files_of, allowed = _other(target)
        return write_folder(path, target, files_of(source, **checked_options(target, options, allowed)))
    own = SUBROUTINE_OPTIONS.get(target, ())
    return write_folder(
        path, target, subroutine_files(source, target, **checked_options(target, options, ("name", *own)))
    )


def _other(target: str) -> tuple[Callable[..., Files], tuple[str, ...]]:
    """Return what makes the files of one of `OTHER_TARGETS`, and the options it takes."""
    if target == "qform":
        from .subroutines.qform_target import OPTIONS as qform_options
        from .subroutines.qform_target import qform_files

        return qform_files, qform_options
    if target == "abaqus":
        from .numbers.abaqus_target import OPTIONS as abaqus_options
        from .numbers.abaqus_target import abaqus_files

        return abaqus_files, abaqus_options
    if target == "table":
        from .numbers.table_target import OPTIONS as table_options
        from .numbers.table_target import table_files

        return table_files, table_options
    from .numbers.fitted_target import OPTIONS as fitted_options
    from .numbers.fitted_target import calculix_files, radioss_files

    return radioss_files if target == "radioss" else calculix_files, fitted_options[target]


def subroutine_files(
    source: FrictionSource, target: str, name: str | None = None, **options: object
) -> Files:
    """Return the files of an export in C, or in Fortran around it.

    Raises InputError: a name that is no identifier, or a graph that is not translated.

    Parameters
    ----------
    target : str
        One of `C_TARGETS`.
    name : str, optional
        First part of the C names.
    **options
        Those of `SUBROUTINE_OPTIONS`.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> source = read_source(ConstantFriction(mu=0.1))
    >>> shared = set(subroutine_files(source, "c", "law")) & set(subroutine_files(source, "vfric", "law"))
    >>> sorted(shared)
    ['LICENSE.txt', 'README.txt', 'card.json', 'law_friction.c', 'law_friction.h', 'model.onnx']
    >>> sorted(set(subroutine_files(source, "ufric", "law")) - shared)
    ['selftest.f90', 'selftest.txt', 'ufric.f']
    >>> sorted(set(subroutine_files(source, "vfric", "law")) - shared)
    ['selftest/selftest.f90', 'selftest/selftest.txt', 'selftest/vaba_param.inc', 'vfric.f']
    """
    from .common import c_prefix, documents, template
    from .subroutines.c_target import c_files, c_sources, c_values
    from .subroutines.deform_target import deform_files
    from .subroutines.lsdyna_target import lsdyna_files
    from .subroutines.ufric_target import ufric_files
    from .subroutines.vfric_target import vfric_files

    prefix = c_prefix(source, name)
    values = c_values(source, prefix)
    values["FORTRAN_MODEL"] = template("model.f", values)
    makers: dict[str, Callable[..., Files]] = {
        "c": c_files,
        "ufric": ufric_files,
        "vfric": vfric_files,
        "deform": deform_files,
        "lsdyna": lsdyna_files,
    }
    return {
        **c_sources(source, prefix),
        **makers[target](source, prefix, values, **options),
        "README.txt": template(f"readme_{target}.txt", values),
        **documents(source),
    }
