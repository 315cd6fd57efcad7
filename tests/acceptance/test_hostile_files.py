"""Every command given hostile or damaged files: one sentence, no traceback, nothing written outside, in bounded time."""

from __future__ import annotations

import multiprocessing.util
import random
import re
import shutil
import tempfile
import typing
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import typer

from fmus.native.compile import build
from friction_models.common import InputError
from orchestrator.cli.app import app
from orchestrator.cli.main import run

from .attacks import ATTACKS, Attack, Sandbox
from .hostile import SECRET, archive, archives, members, texts

#: Texts that name no file to be read: names, numbers, places to write to.
NO_FILES = {
    *("demo.out", "demo.hidden", "report.out", "lab.out", "lab.hidden", "ingest.out", "ingest.test_id", "twin.out"),
    *("points.out", "tests.changes"),
    *("train.family", "train.out", "train.parameters", "twin.parameters", "evaluate.json", "predict.out", "pack.out", "pack.target"),
    *("pack.fmi", "pack.name", "pack.platforms", "pack.parameters", "export.out", "simulate.out", "simulate.mode"),
    *("compare.mode", "compare.process", "compare.parameters", "compare.level", "compare.points"),
    *("compare.runs", "compare.json", "diagnose.json", "diagnose.report", "refine.add", "refine.out"),
    *("verify.only", "verify.json", "verify.out", "predict-sct.out", "predict-sct.only", "predict-sct.json"),
    *("predict-sct.parameters", "coverage.column", "coverage.rig", "coverage.json", "coverage.report"),
    *("coverage.plan", "attribute.causes", "attribute.runs", "attribute.json"),
    *("lab.lubricant", "lab.file_format", "diagnose.plan", "refine.report", "attribute.report"),
    *("cards.search", "cards.json", "cards.report"),
    *("compare.report", "study learning-curve.out", "study learning-curve.scheduler", "study forming-error.out"),
    *("study forming-error.scheduler", "study lag.out", "study lag.model", "study lag.process", "study lag.scheduler"),
    *("study extrapolation.out", "study extrapolation.model", "study extrapolation.process"),
    "study extrapolation.scheduler",
    # tests/orchestrator/app attacks the project folder
    *("app.folder", "app.host", "story.project", "story.out"),
}  # fmt: skip
#: Beside the sentence: progress before it, and the numbered list of a system with several mistakes.
ALLOWED_LINES = re.compile(r"\w+: \d+/\d+ |  \d+\. ")
#: Damage that does not matter where the model description is not validated.
HARMLESS = {"xml_start_is_text", "xml_start_is_nan"}
#: Refused only after a second process has validated the description: two of them are enough for `check`.
SLOW = ("xml_identifier_path", "xml_reference_is_text")
#: These three get every archive, by day the first alone: they look, load and run. The others take turns, so that each archive
#: meets some.
FULL = {"check.fmu", "predict.model", "simulate.swap"}
SHARE = 5
#: By day texts take turns, too: many commands read with the same reader.
SHARE_OF_TEXTS = 3
#: Large ones: for these three only.
HEAVY = {"xml_million_variables", "xml_huge_attribute", "many_files", "lying_size"}


def commands(group: typer.Typer, prefix: str = "") -> Iterator[tuple[str, typer.models.CommandInfo]]:
    """Every command, those of sub-commands with the name of their group (if it has one) before them."""
    for command in group.registered_commands:
        yield prefix + (command.name or str(getattr(command.callback, "__name__", ""))), command
    for inner in group.registered_groups:
        if inner.typer_instance is not None:
            name = inner.name or inner.typer_instance.info.name
            yield from commands(inner.typer_instance, f"{prefix}{name} " if name else prefix)


def test_every_parameter_that_may_be_a_file_is_attacked() -> None:
    """A new command or option has to be put into one of the two lists."""
    attacked = {f"{a.command}.{a.parameter}" for a in ATTACKS}
    for name, command in commands(app):
        for parameter, hint in typing.get_type_hints(command.callback).items():
            kinds = {hint, *typing.get_args(hint)}
            if parameter != "return" and kinds & {Path, str, list[str], list[Path]}:
                assert f"{name}.{parameter}" in attacked | NO_FILES, f"{name}: {parameter} is in no list"


@pytest.fixture(scope="module")
def sandbox(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sandbox]:
    root = tmp_path_factory.mktemp("hostile")
    box = Sandbox(root)
    (root / "tmp").mkdir()
    multiprocessing.util.get_temp_dir()  # made once for the whole of this process: not in the watched folder
    before, tempfile.tempdir = tempfile.tempdir, str(root / "tmp")
    yield box
    tempfile.tempdir = before


@pytest.fixture(scope="module")
def hostile(sandbox: Sandbox) -> dict[str, bytes]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # duplicate names, deliberately
        return archives(sandbox.fmu, sandbox.secret)


Try = Callable[..., str]


@pytest.fixture
def attempt(sandbox: Sandbox, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Try:
    """Run an attack; return what went wrong, empty when it was refused as it should be."""
    monkeypatch.chdir(sandbox.place)
    monkeypatch.delenv("TRIBOFMU_TRACEBACK", raising=False)

    def act(attack: Attack, content: bytes, file: str = "", may_work: bool = False) -> str:
        bad = sandbox.put(attack, content, file)
        before = sandbox.seen()
        code = run(sandbox.arguments(attack, bad))
        said = capsys.readouterr()
        after = sandbox.seen()
        new = [p for p in after if after[p] != before.get(p)] + [p for p in before if p not in after]
        wrong = []
        failed_check = attack.command == "check" and code == 1
        if code not in {1, 2} and not (may_work and code == 0):
            wrong.append(f"exit code {code}")
        lines = [x for x in said.err.strip().splitlines() if not ALLOWED_LINES.match(x)]
        if code and not failed_check and (len(lines) != 1 or not lines[0].startswith("tribofmu: error: ")):
            wrong.append(f"{len(lines)} lines")
        if "Traceback" in said.err + said.out or SECRET in said.err + said.out:
            wrong.append("a traceback, or what is in another file")
        if len(said.err) > 2000 or len(said.out) > 50_000:
            wrong.append(f"{len(said.err) + len(said.out)} characters of output")
        if code:
            wrong += [f"written: {p.relative_to(sandbox.root)}" for p in new]
        else:
            wrong += [f"written: {p}" for p in new if not p.is_relative_to(sandbox.place)]
        for path in sandbox.place.glob("out*"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        return f"{', '.join(wrong)} ({said.err[-300:].strip()})" if wrong else ""

    return act


def label(attack: Attack) -> str:
    return f"{attack.command}-{attack.parameter}-{attack.kind}"


@pytest.mark.parametrize("attack", [a for a in ATTACKS if a.kind == "fmu"], ids=label)
@pytest.mark.parametrize(
    "full", [{"check.fmu"}, pytest.param(FULL, marks=pytest.mark.nightly)], ids=["check", "all three"]
)
def test_hostile_fmus(
    attack: Attack, full: set[str], attempt: Try, hostile: dict[str, bytes], sandbox: Sandbox
) -> None:
    found = {}
    for name, content in chosen(attack, hostile, full):
        loaded = name.startswith("xml_") and attack.command == "check"
        if not loaded or name in SLOW or refused_at_once(content, sandbox):
            found[name] = attempt(attack, content, may_work=name in HARMLESS)
    assert not {n: w for n, w in found.items() if w}


def chosen(attack: Attack, hostile: dict[str, bytes], full: set[str]) -> list[tuple[str, bytes]]:
    """The archives that an attack uses."""
    if f"{attack.command}.{attack.parameter}" in full:
        return [*hostile.items()]
    usual = [(n, c) for n, c in hostile.items() if n not in HEAVY]
    return usual[ATTACKS.index(attack) % SHARE :: SHARE]


def refused_at_once(content: bytes, sandbox: Sandbox) -> bool:
    from fmus.archive.content import read_description

    path = sandbox.place / "bad.fmu"
    path.write_bytes(content)
    try:
        read_description(path)
    except InputError:
        return True
    return False


@pytest.mark.parametrize("attack", [a for a in ATTACKS if a.kind == "ssp"], ids=label)
def test_hostile_system_archives(
    attack: Attack, attempt: Try, hostile: dict[str, bytes], sandbox: Sandbox
) -> None:
    """Hostile as an archive, and an archive with a hostile FMU in it."""
    files = members(sandbox.root / "good.ssp")
    inner = next(n for n in files if n.endswith(".fmu"))
    found = {}
    for name, content in chosen(attack, hostile, FULL):
        if name not in HARMLESS:
            found[f"in it {name}"] = attempt(attack, archive(files | {inner: content}))
        if not name.startswith("xml_"):
            found[name] = attempt(attack, content)
    whole = (sandbox.root / "good.ssp").read_bytes()
    for part in (0.1, 0.5, 0.9):
        found[f"cut_{part}"] = attempt(attack, whole[: int(part * len(whole))])
    entity = f'<!DOCTYPE x [<!ENTITY e SYSTEM "{sandbox.secret.as_uri()}">]>'.encode()
    description = files["SystemStructure.ssd"]
    root = description.index(b"<", description.index(b"?>"))
    changed = {
        "entity": description[:root] + entity + description[root:].replace(b'name="', b'name="&e;', 1),
        "escape": description.replace(b"resources/", b"../../"),
        "absolute": description.replace(b"resources/", b"/etc/"),
        "address": description.replace(b"resources/", b"file:///etc/"),
        "cut": description[: len(description) // 2],
        "other": b"<svg/>",
    }
    for name, content in changed.items():
        found[f"description {name}"] = attempt(attack, archive(files | {"SystemStructure.ssd": content}))
    assert not {n: w for n, w in found.items() if w}


@pytest.mark.parametrize("attack", [a for a in ATTACKS if a.kind not in {"fmu", "ssp"}], ids=label)
@pytest.mark.parametrize("share", [SHARE_OF_TEXTS, pytest.param(1, marks=pytest.mark.nightly)])
def test_hostile_texts(attack: Attack, attempt: Try, sandbox: Sandbox, share: int) -> None:
    found = {}
    for name, content in [*texts(sandbox.secret).items()][ATTACKS.index(attack) % share :: share]:
        for file in attack.files or ("",):
            # A remark beside the data may be missing, and then be empty; a list of tests may be anything readable.
            found[f"{name} {file}"] = attempt(attack, content, file)
    assert not {n: w for n, w in found.items() if w}


@pytest.mark.parametrize(
    "attack",
    [a for a in ATTACKS if f"{a.command}.{a.parameter}" in {"predict.model", "simulate.swap"}],
    ids=label,
)
def test_flipped_bits(attack: Attack, attempt: Try, sandbox: Sandbox) -> None:
    """Bits of the archive, and of the model description in a whole archive: worked or refused, never worse."""
    draw = random.Random(attack.parameter)
    whole, files = sandbox.fmu.read_bytes(), members(sandbox.fmu)
    xml = files["modelDescription.xml"]
    directory = whole.index(b"PK\x01\x02")
    found = {}
    for k in range(40):
        changed = bytearray(whole)
        for _ in range(draw.randint(1, 4)):
            changed[draw.choice([draw.randrange(len(whole)), draw.randrange(directory, len(whole))])] ^= (
                1 << draw.randrange(8)
            )
        found[f"archive {k}"] = attempt(attack, bytes(changed), may_work=True)
    for k in range(25):
        changed = bytearray(xml)
        for _ in range(draw.randint(1, 3)):
            changed[draw.randrange(len(xml))] ^= 1 << draw.randrange(7)
        found[f"description {k}"] = attempt(
            attack, archive(files | {"modelDescription.xml": bytes(changed)}), may_work=True
        )
    assert not {n: w for n, w in found.items() if w}


@pytest.mark.parametrize("attack", [a for a in ATTACKS if f"{a.command}.{a.parameter}" in FULL], ids=label)
def test_no_library_outside_the_archive_is_loaded(attack: Attack, attempt: Try, sandbox: Sandbox) -> None:
    """The name of the binary leads to a library beside the archive, which would leave a file when it is loaded."""
    source = (
        "#include <stdio.h>\n"
        '__attribute__((constructor)) static void loaded(void) { fclose(fopen("loaded.txt", "w")); }\n'
    )
    try:
        built = build({"outside.c": source}, "outside.c", "outside")
    except (InputError, RuntimeError) as error:
        pytest.skip(f"no library can be built here: {error}")
    folder, content = next(iter(built.items()))
    suffix = Path(folder).suffix
    (sandbox.root / f"outside{suffix}").write_bytes(content)
    files = members(sandbox.fmu)
    xml = files["modelDescription.xml"]
    identifier = re.search(b'modelIdentifier="(.*?)"', xml).group(1)  # type: ignore[union-attr]
    up = "../" * 40 + (sandbox.root / "outside").as_posix().lstrip("/")
    for place in (up, (sandbox.root / "outside").as_posix()):
        changed = xml.replace(identifier + b'"', place.encode() + b'"')
        assert attempt(attack, archive(files | {"modelDescription.xml": changed})) == ""
    assert not [*sandbox.root.rglob("loaded.txt")]
