"""`check` of FMUs that misbehave, or compute something else than they say."""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from fmus import check, pack
from fmus.archive.content import write_archive
from fmus.checks.checking import MEMORY_LIMIT
from fmus.checks.trial import problems_of
from fmus.native import compile as compiling
from tests.fmus.graphs import BOX, graph_bytes, node, save

#: What a library does as soon as it is loaded.
EVIL = """
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>
__attribute__((constructor)) static void evil(void)
{
#if KIND == 1
    for (;;) pause();
#elif KIND == 2
    if (fork() == 0) for (;;) pause();
    _exit(0);
#elif KIND == 3
    raise(SIGSEGV);
#else
    for (;;) {
        volatile char *room = malloc(1 << 24);
        if (!room) abort();
        for (int k = 0; k < 1 << 24; k += 4096) room[k] = 1;
    }
#endif
}
"""


def content_of(fmu: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(fmu) as archive:
        return {n: archive.read(n) for n in archive.namelist()}


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """FMUs of a curved law with a memory in both versions."""
    folder = tmp_path_factory.mktemp("good")
    import numpy as np

    nodes = [
        node("Mul", "loads scale", "x"),
        node("Gemm", "x w", "y"),
        node("Tanh", "y", "t"),
        node("Mul", "t tenth", "s"),
        node("Add", "s fifth", "mu"),
    ]
    constants = {
        "scale": np.array([1 / 500.0, 1 / 400.0, 1 / 2750.0, 1 / 60.0, 1 / 20.0]),
        "w": np.array([[0.3], [-0.4], [0.5], [0.2], [0.1]]),
        "tenth": np.array(0.1),
        "fifth": np.array(0.2),
    }
    model = save(graph_bytes(nodes, constants, metadata={"domain": BOX}), folder / "curved.onnx")
    return {v: pack(model, folder / f"good{v[0]}.fmu", fmi=v, arrays=v == "3.0") for v in ("2.0", "3.0")}


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_both_versions_pass_in_all_groups(fmi: str, good: dict[str, Path]) -> None:
    report = check(good[fmi])
    assert report.ok, str(report)
    text = str(report)
    assert text.startswith(f"{good[fmi]}: ok (")
    expected = [
        "archive",
        "model description",
        "platforms",
        "co-simulation",
        "friction",
        "model exchange",
        "reference results",
    ]
    assert list(dict.fromkeys(f.group for f in report.findings)) == expected
    wanted = ["schema and semantics", "exact replay after serialization", "directional derivatives against"]
    wanted += ["mu is that of co-simulation", "checksums fit", "a reset instance", "in_domain is true"]
    if fmi == "3.0":
        wanted += ["with n = 7: largest difference", "adjoint derivatives fit", "n can be set from 1 to"]
    passed = "\n".join(f.text for f in report.findings if f.outcome in {"passed", "noted"})
    assert [w for w in wanted if w not in passed] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "words"),
    [
        pytest.param(1, "not finished after 8 s, ended", id="hangs"),
        pytest.param(
            2,
            "the second process ended early: exit code 0",
            id="exits",
            marks=pytest.mark.nightly,
        ),
        pytest.param(
            3,
            "the second process ended early: stopped by SIGSEGV",
            id="crashes",
            marks=pytest.mark.nightly,
        ),
        pytest.param(4, "the second process ended early: stopped by SIGABRT", id="takes all memory"),
    ],
)
def test_a_library_that_misbehaves_does_not_take_check_down(
    kind: int, words: str, good: dict[str, Path], tmp_path: Path
) -> None:
    if not compiling.host_platform().name.endswith("-linux"):
        pytest.skip("the libraries of this test are written for Linux")
    files = content_of(good["2.0"])
    name = next(n for n in files if n.startswith("binaries/"))
    source = f"#define _GNU_SOURCE\n#define KIND {kind}\n{EVIL}"
    (files[name],) = compiling.build({"evil.c": source}, "evil.c", "evil").values()
    fmu = write_archive(tmp_path / "evil.fmu", files)
    before = sorted(p.name for p in tmp_path.iterdir())
    report = check(fmu, time_limit=8.0 if kind == 1 else 60.0, memory_limit=1024**3)
    assert not report.ok
    failed = [f.text for f in report.findings if f.outcome == "failed"]
    assert any("functions of FMI are missing" in text for text in failed)
    assert words in failed[-1]
    # What was found before stays.
    assert any(f.text.startswith("schema and semantics") for f in report.findings)
    assert sorted(p.name for p in tmp_path.iterdir()) == before


def test_how_python_itself_ends_says_nothing_of_the_fmu(good: dict[str, Path], tmp_path: Path) -> None:
    start = "import atexit, os; atexit.register(os.abort); from fmus.checks.trial import main; main()"
    result = tmp_path / "result.json"
    command = [sys.executable, "-c", start, str(good["2.0"]), str(result), str(MEMORY_LIMIT)]
    assert subprocess.run(command, cwd=Path(__file__).parents[2], timeout=120).returncode == 0
    assert result.read_text().splitlines()[-1] == '["end", "", ""]'


SABOTAGE = {
    "drift": (
        "static void tf_wrong_mu(const double *L, const double *S, const double *P, double *out)\n"
        "{ static int calls; tf_model_mu(L, S, P, out); out[0] += 1e-3 * ++calls; }\n"
        "#define tf_model_mu tf_wrong_mu\n",
        ["a second instance repeats", "a reset instance repeats", "mu against ONNX Runtime", "experiment"],
    ),
    "slope": (
        "static void tf_wrong_mu_d(const double *L, const double *S, const double *P, const double *dL,\n"
        "    const double *dS, const double *dP, double *out, double *dout)\n"
        "{ tf_model_mu_d(L, S, P, dL, dS, dP, out, dout); dout[0] *= 1.001; }\n"
        "#define tf_model_mu_d tf_wrong_mu_d\n",
        ["directional derivatives against central differences"],
    ),
    "offset": (
        "static void tf_wrong_mu(const double *L, const double *S, const double *P, double *out)\n"
        "{ tf_model_mu(L, S, P, out); out[0] += 1e-8; }\n"
        "#define tf_model_mu tf_wrong_mu\n",
        ["mu against ONNX Runtime", "experiment"],
    ),
}


@pytest.mark.usefixtures("trials_here")
@pytest.mark.parametrize("name", SABOTAGE)
def test_a_library_that_computes_something_else_is_found(
    name: str, good: dict[str, Path], tmp_path: Path
) -> None:
    patch, words = SABOTAGE[name]
    files = content_of(good["2.0"])
    sources = {n.removeprefix("sources/"): c.decode() for n, c in files.items() if n.startswith("sources/")}
    sources = {n: t for n, t in sources.items() if n.endswith((".c", ".h"))}
    sources["model.h"] += patch
    sources |= compiling.fmi_headers("2.0")
    library = next(n for n in files if n.startswith("binaries/"))
    (files[library],) = compiling.build(sources, "fmi2.c", "wrong").values()
    report = check(write_archive(tmp_path / "wrong.fmu", files))
    failed = [f.text for f in report.findings if f.outcome == "failed"]
    for start in words:
        assert any(text.startswith(start) for text in failed), str(report)
    assert [t for t in failed if not t.startswith((*words, "FMU state"))] == []


@pytest.mark.usefixtures("trials_here")
@pytest.mark.parametrize(
    ("member", "old", "new", "words"),
    [
        ("references.csv", b"0.", b"0.9", "is not the file that the manifest describes"),
        ("experiments.xml", b"<Experiments", b"<!DOCTYPE x []><Experiments", "declares a document type"),
        ("fmi-ls-manifest.xml", b'source="references.csv"', b'source="../../../x"', "is no file of the FMU"),
    ],
)
def test_damaged_reference_results_are_found(
    member: str, old: bytes, new: bytes, words: str, good: dict[str, Path], tmp_path: Path
) -> None:
    files = content_of(good["2.0"])
    name = f"extra/org.fmi-standard.fmi-ls-ref/{member}"
    assert old in files[name]
    files[name] = files[name].replace(old, new, 1)
    path = write_archive(tmp_path / "changed.fmu", files)
    if "document type" in words:
        from friction_models.common import InputError

        with pytest.raises(InputError, match=words):
            check(path)
        return
    report = check(path)
    assert any(words in f.text for f in report.findings if f.outcome == "failed"), str(report)


@pytest.mark.usefixtures("trials_here")
@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_model_exchange_alone_is_checked(fmi: str, good: dict[str, Path], tmp_path: Path) -> None:
    files = content_of(good[fmi])
    xml = files["modelDescription.xml"]
    files["modelDescription.xml"] = re.sub(
        rb"<CoSimulation[^>]*?(/>|>.*?</CoSimulation>)", b"", xml, flags=re.S
    )
    assert files["modelDescription.xml"] != xml
    report = check(write_archive(tmp_path / "exchange.fmu", files))
    assert report.ok, str(report)
    assert "skipped: not offered" in report.messages
    assert any("mu against ONNX Runtime at the start" in text for text in report.messages)


@pytest.mark.parametrize(
    ("name", "allowed"),
    [
        ("mu", True),
        ("v_rel[12]", True),
        ("a.b[1,2].c", True),
        ("der(a.b[3],2)", True),
        ("'any name'.c", True),
        ("a-b", False),
        ("1a", False),
        ("der(x", False),
        ("a[]", False),
        ("a[x]", False),
    ],
)
def test_names_of_variables_are_validated(
    name: str, allowed: bool, good: dict[str, Path], tmp_path: Path
) -> None:
    """The same names as fmpy's own, slow validation lets pass."""
    from fmpy.validation import validate_fmu

    files = content_of(good["2.0"])
    xml = files["modelDescription.xml"].replace(b'name="domain_distance"', f'name="{name}"'.encode())
    if name == "mu":
        xml = files["modelDescription.xml"]
    path = write_archive(tmp_path / "names.fmu", files | {"modelDescription.xml": xml})
    assert (problems_of(path) == []) == allowed
    assert (validate_fmu(str(path)) == []) == allowed


FOREIGN = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

class Foreign(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.x, self.u = 1.0, 2.0
        self.register_variable(Real("x", causality=Fmi2Causality.output))
        self.register_variable(Real("u", causality=Fmi2Causality.input))

    def do_step(self, time, step):
        self.x += step * self.u
        return True
"""


def test_an_fmu_of_another_tool_is_checked(tmp_path: Path) -> None:
    """Its description has a gap that fmpy knows of; everything else is looked at all the same."""
    from pythonfmu.builder import FmuBuilder

    script = tmp_path / "foreign.py"
    script.write_text(FOREIGN)
    report = check(FmuBuilder.build_FMU(script, dest=tmp_path))
    failed = [f.text for f in report.findings if f.outcome == "failed"]
    assert failed[0] == "schema and semantics (fmpy)"
    assert "InitialUnknowns" in failed[1]
    assert len(failed) == 2, str(report)
    text = str(report)
    assert "symbols must come from the program that loads it (Py" in text
    assert "noted   NaN as 'u' is accepted" in text
    assert "a second instance repeats the first exactly" in text
    assert "made by PythonFMU" in text


@pytest.mark.usefixtures("trials_here")
def test_a_library_in_the_wrong_folder_is_found(good: dict[str, Path], tmp_path: Path) -> None:
    files = content_of(good["2.0"])
    name = next(n for n in files if n.startswith("binaries/"))
    files[f"binaries/win64/{Path(name).stem}.dll"] = files[name]
    files[f"binaries/win32/{Path(name).stem}.dll"] = b"no library"
    report = check(write_archive(tmp_path / "folders.fmu", files))
    failed = "\n".join(f.text for f in report.findings if f.outcome == "failed")
    assert "the folder is for x86_64-windows" in failed
    assert f"win32/{Path(name).stem}.dll: not a shared library" in failed
