"""From a packed FMU to a fuzz program: sources unpacked, the variables as a C table, a compiler with sanitizers."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from lxml import etree

from fmus.native.compile import fmi_headers

HERE = Path(__file__).parent
ADDRESS = ("-fsanitize=address,undefined", "-fsanitize=float-cast-overflow", "-fno-sanitize-recover=all")
THREAD = ("-fsanitize=thread",)
TRAPS = ("-fsanitize=undefined", "-fsanitize-trap=undefined")
_CAUSALITY = {
    "input": "i",
    "output": "o",
    "parameter": "p",
    "structuralParameter": "s",
    "independent": "t",
    "local": "l",
}


@dataclass(frozen=True)
class Compiler:
    """A C compiler with sanitizers that work here.

    Attributes
    ----------
    command, flags : tuple of str
    environment : dict
        For the programs it makes.
    what : str
        What the programs notice.
    """

    command: tuple[str, ...]
    flags: tuple[str, ...]
    what: str
    environment: dict[str, str] = field(default_factory=dict)


@cache
def compiler(flags: tuple[str, ...] = ADDRESS) -> Compiler | None:
    """Return a compiler whose programs run with these sanitizers, None when there is none.

    Without a system compiler Zig's is taken for the default flags: undefined behaviour ends the program there.
    """
    for name in ("gcc", "clang", "cc"):
        found = shutil.which(name)
        for environment in ({}, {"ASAN_OPTIONS": "detect_leaks=0"}):
            if found and _works((found,), flags, environment):
                return Compiler((found,), flags, " ".join(flags), environment)
    zig = (sys.executable, "-m", "ziglang", "cc")
    if flags == ADDRESS and _works(zig, TRAPS, {}):
        return Compiler(zig, TRAPS, "undefined behaviour only (no AddressSanitizer)")
    if not flags and _works(zig, (), {}):
        return Compiler(zig, (), "")
    return None


def _works(command: tuple[str, ...], flags: tuple[str, ...], environment: dict[str, str]) -> bool:
    """Whether a program can be built with these flags, and runs."""
    with tempfile.TemporaryDirectory(prefix="tribofmu-probe-") as folder:
        text = "#include <stdlib.h>\nint main(void) { free(malloc(3)); return 0; }\n"
        (Path(folder) / "probe.c").write_text(text)
        built = subprocess.run([*command, *flags, "probe.c", "-o", "probe"], cwd=folder, capture_output=True)
        if built.returncode:
            return False
        program = str(Path(folder) / "probe")
        return subprocess.run([program], env=os.environ | environment, capture_output=True).returncode == 0


def unpack_sources(fmu: Path, folder: Path) -> tuple[str, list[str]]:
    """Unpack `sources/`, add the headers of the standard and `variables.h`; return version and C files to compile."""
    with zipfile.ZipFile(fmu) as archive:
        for name in archive.namelist():
            if name.startswith("sources/") and not name.endswith("/"):
                (folder / Path(name).name).write_bytes(archive.read(name))
        root = etree.fromstring(archive.read("modelDescription.xml"))
    (folder / "variables.h").write_text(variables_header(root), encoding="utf-8")
    version = root.get("fmiVersion")
    for name, text in fmi_headers(version).items():
        (folder / name).write_text(text, encoding="utf-8")
    if version == "2.0":
        return version, [f.get("name") for f in root.find("CoSimulation").iter("File")]
    build = etree.parse(folder / "buildDescription.xml").getroot()
    return version, [f.get("name") for f in build.iter("SourceFile")]


def variables_header(root: etree._Element) -> str:
    """Return the model description as C: a table of variables and a few numbers."""
    version2 = root.get("fmiVersion") == "2.0"
    rows = []
    elements = list(root.find("ModelVariables"))
    for variable in elements:
        details = variable[0] if version2 else variable
        kind = {"Real": "R", "Float64": "R", "Boolean": "B", "UInt64": "U"}[etree.QName(details).localname]
        causality = _CAUSALITY[variable.get("causality", "local")]
        if details.get("derivative"):
            causality = "d"
        array = int(variable.find("Dimension") is not None)
        numbers = [_c(details.get("min"), "-INFINITY"), _c(details.get("max"), "INFINITY")]
        start = _c((details.get("start") or "").split(" ")[0] or None, "0.0")
        name = variable.get("name")
        rows.append(
            f"    {{\"{name}\", {variable.get('valueReference')}u, '{kind}', '{causality}', {array}, "
            f"{numbers[0]}, {numbers[1]}, {start}}},"
        )
    structure = root.find("ModelStructure")
    if version2:
        states = len(root.findall("ModelStructure/Derivatives/Unknown"))
        indicators = int(root.get("numberOfEventIndicators") or 0)
    else:
        states = len(structure.findall("ContinuousStateDerivative"))
        indicators = len(structure.findall("EventIndicator"))
    memory = any(", 'l', " in row and "indicator" not in row for row in rows)
    count = next((v for v in elements if v.get("causality") == "structuralParameter"), None)
    token = root.get("guid") or root.get("instantiationToken")
    return "\n".join(
        [
            f'#define FUZZ_TOKEN "{token}"',
            f"#define FUZZ_EXCHANGE {int(root.find('ModelExchange') is not None)}",
            f"#define FUZZ_STATES {states}",
            f"#define FUZZ_INDICATORS {indicators}",
            f"#define FUZZ_MEMORY {int(memory)}",
            f"#define FUZZ_POINTS {count.get('valueReference') if count is not None else 0}",
            f"#define FUZZ_SIZED {int(count is not None)}",
            f"#define FUZZ_N {count.get('start') if count is not None else 1}",
            "static const variable variables[] = {",
            *rows,
            "};",
            "",
        ]
    )


def _c(text: str | None, empty: str) -> str:
    if text is None:
        return empty
    if text in {"true", "false"}:
        return str(int(text == "true"))
    return {"INF": "INFINITY", "-INF": "(-INFINITY)"}.get(text.upper(), text)


def build(fmu: Path, folder: Path, tool: Compiler, program: str = "", *options: str) -> Path:
    """Compile a program of this folder with the sources of an FMU; return the executable.

    Parameters
    ----------
    fmu : Path
    folder : Path
        An empty folder to work in.
    tool : Compiler
    program : str
        C file; the fuzzer of the FMU's version by default.
    options : str
        More options of the compiler. With ``-DLINKED`` or a fuzzer the FMU's sources are linked in.
    """
    version, sources = unpack_sources(fmu, folder)
    main = HERE / (program or f"fuzz_fmi{version[0]}.c")
    output = folder / main.stem
    # To compile takes ten times as long as some ten thousand random calls: a fuzzer is not optimised.
    level = "-O1" if program else "-O0"
    common = [*tool.command, *tool.flags, "-std=c99", "-g", level, "-ffp-contract=off", "-Wall", "-Wextra"]
    include = ["-I.", f"-I{HERE}"]
    objects = [f"{n}.o" for n in range(len(sources))] if not program or "-DLINKED" in options else []
    starving = [] if program else ["-include", str(HERE / "starving.h")]
    for source, made in zip(sources, objects):
        _run([*common, *include, *starving, *options, "-c", source, "-o", made], folder)
    _run(
        [*common, *include, *options, str(main), *objects, "-o", str(output), "-lm", "-ldl", "-pthread"],
        folder,
    )
    return output


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}\n{done.stderr[-4000:]}")
    if "warning:" in done.stderr:
        print(done.stderr, file=sys.stderr)


def run(program: Path, tool: Compiler, *arguments: object) -> subprocess.CompletedProcess[str]:
    """Run a program and return how it ended."""
    return subprocess.run(
        [str(program), *map(str, arguments)],
        env=os.environ | tool.environment,
        capture_output=True,
        text=True,
        timeout=600,
    )
