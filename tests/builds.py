"""What the C compiler made is kept among all processes of a run of the tests: half of the builds are of the same sources."""

from __future__ import annotations

import os
import tempfile
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from fmus.native import compile as compiling
from friction_models.common.cached_results import fingerprint

Build = Callable[..., dict[str, bytes]]


class KeptBuilds:
    """Stands in for `fmus.native.compile.build`; equal input to the same compiler is compiled once.

    Parameters
    ----------
    build : callable
        What compiles.
    folder : Path
        One for all processes of the run.
    """

    def __init__(self, build: Build, folder: Path) -> None:
        self.build, self.folder = build, folder
        folder.mkdir(exist_ok=True)

    def __call__(
        self,
        sources: Mapping[str, str],
        main: str,
        identifier: str,
        platforms: Sequence[str] | None = None,
        fmi: str = "2.0",
    ) -> dict[str, bytes]:
        compiler = [compiling.zig_command(), compiling.system_command(), compiling._FLAGS]
        wanted = None if platforms is None else [*platforms]
        kept = self.folder / fingerprint(sorted(sources.items()), main, identifier, wanted, fmi, *compiler)
        if kept.is_file():
            with zipfile.ZipFile(kept) as archive:
                return {name: archive.read(name) for name in archive.namelist()}
        built = self.build(sources, main, identifier, platforms, fmi)
        handle, temporary = tempfile.mkstemp(dir=self.folder)
        with os.fdopen(handle, "wb") as stream, zipfile.ZipFile(stream, "w") as archive:
            for name, content in built.items():
                archive.writestr(name, content)
        os.replace(temporary, kept)
        return built
