"""Installs a wheel into a clean environment, alone and away from the sources, and does the main job with it.

``python -m tests.wheel_alone dist/*.whl`` ends with an error where one of these fails:

- every file of the packages that git knows is in the wheel;
- the core does the main job: cards, train, predict, diagnose, refine, pack, check, simulate, export for a host;
- what the core leaves out is refused by one sentence that names the extra;
- ``import friction_models, fmus, orchestrator`` loads nothing that is heavy.

It prints the size of the environment without pip and setuptools.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("friction_models", "forming", "sct_twin", "fmus", "orchestrator")
#: What an import of the packages must not load.
HEAVY = (
    "numpy",
    "pandas",
    "scipy",
    "sklearn",
    "onnx",
    "onnxruntime",
    "xarray",
    "numba",
    "plotly",
    "fmpy",
    "torch",
    "pyarrow",
)
SYSTEM = """\
name: alone
communication_step: 0.1
stop_time: 0.3
components:
  friction: {fmu: friction.fmu}
connections: []
"""
#: Commands of the main job; {data} is the example that comes with the package.
MAIN_JOB = (
    "cards seal-kdn",
    "train linear --data {data} -o linear",
    "predict linear --data {data} -o predicted.csv",
    "diagnose --data {data} --model linear --json diagnosis.json",
    "refine --data {data} --model linear --add stribeck -o better",
    "compare --models linear better card:cold-forging-median --data {data}",
    "pack better -o friction.fmu",
    "check friction.fmu",
    "simulate alone.yaml -o run",
    "pack better --target c -o host",
)
#: Commands that need an extra, and the extra.
REFUSED = {
    "pack forming -o forming.fmu": "solvers",
    "lab --plan reduced-27+10 -o campaign": "solvers",
    "diagnose --data {data} --model linear --report page.html": "reports",
    "app project": "app",
}


def missing_files(wheel: Path) -> list[str]:
    """Return the files of the packages that git knows and the wheel lacks."""
    known = subprocess.run(
        ["git", "ls-files", *PACKAGES], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return sorted(set(known.stdout.split()) - set(zipfile.ZipFile(wheel).namelist()))


def main(wheel: Path) -> None:
    """Do all of it in a temporary folder."""
    if lacks := missing_files(wheel):
        sys.exit(f"{wheel.name} lacks {', '.join(lacks)}")
    with tempfile.TemporaryDirectory() as place:
        work = Path(place)
        venv.create(work / "env", with_pip=True)
        python = next(p for p in (work / "env/bin/python", work / "env/Scripts/python.exe") if p.is_file())
        pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run(
            [*pip, "-c", str(ROOT / "constraints.txt"), str(wheel.resolve())], check=True, cwd=work
        )
        own = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}

        def ask(code: str) -> str:
            done = subprocess.run(
                [str(python), "-I", "-c", code], cwd=work, env=own, capture_output=True, text=True, check=True
            )
            return done.stdout.strip()

        def tribofmu(line: str) -> subprocess.CompletedProcess[str]:
            words = [word.format(data=data) for word in line.split()]
            return subprocess.run(
                [str(python.with_name("tribofmu")), *words], cwd=work, env=own, capture_output=True, text=True
            )

        loaded = ask(
            f"import sys, friction_models, fmus, orchestrator; print(*[m for m in {HEAVY!r} if m in sys.modules])"
        )
        if loaded:
            sys.exit(f"import of the packages loads {loaded}")
        data = ask(
            "from importlib.resources import files; print(files('orchestrator.app') / 'example' / 'data' / 'sct')"
        )
        if not data.startswith(place):
            sys.exit(f"the packages were not imported from the wheel: {data}")
        (work / "alone.yaml").write_text(SYSTEM, encoding="utf-8")
        for line in MAIN_JOB:
            done = tribofmu(line)
            print("tribofmu", line.split(" --data")[0], "->", done.returncode)
            if done.returncode:
                sys.exit(done.stderr)
        for line, extra in REFUSED.items():
            done = tribofmu(line)
            if done.returncode != 2 or f"tribofmu[{extra}]" not in done.stderr:
                sys.exit(f"tribofmu {line}: exit code {done.returncode}, {done.stderr}")
        purelib = Path(ask("import sysconfig; print(sysconfig.get_path('purelib'))"))
        tools = ("pip", "setuptools", "pkg_resources", "_distutils_hack", "distutils-precedence")
        size = sum(
            f.lstat().st_blocks * 512
            for f in purelib.rglob("*")
            if not f.relative_to(purelib).parts[0].startswith(tools)
        )
    print(f"{wheel.name}: {size / 1e6:.0f} MB with all that the core needs, Python {sys.version.split()[0]}")


if __name__ == "__main__":
    for name in sys.argv[1:]:
        main(Path(name))
