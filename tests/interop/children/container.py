"""fmucontainer: FMUs, or an SSP, in one container FMU."""

from __future__ import annotations

from pathlib import Path

from tests.interop.children.common import done, job


def main() -> None:
    from fmu_manipulation_toolbox.assembly import Assembly

    work = job()
    folder = Path(work["folder"])
    assembly = Assembly(work["description"], default_step_size=work["step"], fmu_directory=folder)
    assembly.make_fmu(fmi_version=int(work.get("fmi", 2)))
    done([sorted(p.name for p in folder.glob("*.fmu"))])


if __name__ == "__main__":
    main()
