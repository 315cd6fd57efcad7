"""One try: a command, a damaged input, an output; and what was wrong with what it did."""

from __future__ import annotations

import os
import random
import re
import shutil
from dataclasses import dataclass, field
from pathlib import Path

from tests.acceptance.attacks import ATTACKS, Attack
from tests.acceptance.hostile import SECRET
from tests.acceptance.test_hostile_files import ALLOWED_LINES

from . import archive_damage, outputs
from .child import Ended, in_child
from .stock import Box, good

#: Longest sentence and longest output [characters].
SENTENCE, TEXT = 1500, 100_000
#: They keep what they have finished when something fails in the middle, so that a second run goes on from there.
PARTIAL = {
    "lab",
    "twin",
    "predict-sct",
    "simulate",
    "study learning-curve",
    "study forming-error",
    "study lag",
}
PARTIAL |= {"study extrapolation"}
#: How to read what a command has written: ``{out}`` is that, ``{next}`` a new name.
NEXT = {
    "predict": "evaluate 0.1 --data {out}",
    "pack": "evaluate {out} --data {data}",
    "export": "simulate {out} -o {next}",
    "simulate": "report {out} -o {next}.html",
    "train": "evaluate {out} --data {data}",
    "refine": "evaluate {out} --data {data}",
    "twin": "evaluate 0.1 --data {out}",
}
#: What a command may replace: an earlier output of its own kind.
OWN = {"train": "linear", "refine": "linear", "simulate": "more/run", "twin": "data"}
#: They solve or fit for seconds where the input is good: drawn less often.
SLOW = {"twin", "lab", "predict-sct", "refine", "diagnose", "attribute", "compare.press"}
JOBS = {"twin", "lab", "predict-sct", "attribute"}
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x0c\x0e-\x1f\x7f\x85\u2028\u2029\u202e]")
#: What the next command may say: the file is as good as its source was.
_HONEST = re.compile(
    r"is not a finite number|no binary for the platform|column 'mu'|in loading: its process was ended by SIG|the binary cannot be loaded"
)
_RAW = re.compile(
    r"(error: |^)[A-Z]\w*(Error|Exception|Warning|Exit|Interrupt)\b|\.py:\d+: \w*Warning", re.MULTILINE
)


@dataclass
class Try:
    """What was done and what came of it.

    Attributes
    ----------
    number : int
    command : str
        Command line, with paths below the sandbox.
    damage : str
        What was done to the input and the output.
    code : int
    seconds : float
    wrong : list of str
        What should not have happened.
    said : str
        The end of stderr.
    """

    number: int
    name: str
    command: str
    damage: str
    code: int = 0
    seconds: float = 0.0
    wrong: list[str] = field(default_factory=list)
    said: str = ""


def one_try(seed: int, number: int, box: Box, limit: float, quick: bool = False) -> Try:
    """Make a try; the same seed and number make the same one. A quick one is of no command that solves for seconds."""
    draw = random.Random(f"{seed}-{number}")
    attack = _drawn_attack(draw, 0.0 if quick else 0.3)
    bad, damage = _damaged(draw, attack, box)
    bare = "{out}" in attack.arguments.split()
    output = outputs.drawn(draw, box, bad, bare) if "{out}" in attack.arguments else outputs.Output("")
    words = box.words(
        attack, os.path.relpath(bad, box.place) if draw.random() < 0.3 else str(bad), output.text
    )
    if attack.command in JOBS:
        words += ["--jobs", "1"]
    final = Path(os.path.normpath(box.place / words[words.index("-o") + 1])) if "-o" in words else None
    if output.prepare is not None and final is not None:
        output.prepare(final)
    before = box.look()
    ended = in_child(words, box.place, box.root, limit)
    after = box.look()
    tried = Try(
        number,
        f"{attack.command}.{attack.parameter}",
        _short(" ".join(words), box),
        "; ".join(d for d in (damage, output.label) if d),
        ended.code,
        ended.seconds,
        _judged(attack, ended) + _touched(attack, ended, before, after, final, box),
        _short(ended.err[-600:].strip(), box),
    )
    if ended.code == 0 and not tried.wrong and final is not None and attack.command in NEXT:
        tried.wrong += _unreadable(attack, final, box, limit)
    _tidy(box, after if tried.wrong else {})
    return tried


def _drawn_attack(draw: random.Random, share: float) -> Attack:
    weights = [share if a.command in SLOW or f"{a.command}.{a.parameter}" in SLOW else 1.0 for a in ATTACKS]
    return draw.choices(ATTACKS, weights)[0]


def _damaged(draw: random.Random, attack: Attack, box: Box) -> tuple[Path, str]:
    """Put a damaged copy of a good input into the sandbox; return it and what is wrong with it."""
    source = box.root / good(attack)
    bad = box.place / ("bad" if source.is_dir() else f"bad{source.suffix}")
    kind = draw.random()
    if kind < 0.05:
        return bad, "the input is good" + _copy(source, bad)
    if kind < 0.13:
        return bad, _misplaced(draw, source, bad, box)
    if source.is_dir():
        shutil.copytree(source, bad)
        return bad, archive_damage.folder(draw, bad, box.secret)
    content, what = archive_damage.damaged(draw, source.name, source.read_bytes())
    bad.write_bytes(content)
    return bad, f"the input is damaged: {what}"


def _copy(source: Path, bad: Path) -> str:
    shutil.copytree(source, bad) if source.is_dir() else shutil.copyfile(source, bad)
    return ""


def _misplaced(draw: random.Random, source: Path, bad: Path, box: Box) -> str:
    """Put something of another kind where the input should be."""
    match draw.randrange(7):
        case 0:
            return "the input is missing"
        case 1:
            bad.mkdir()
            return "the input is an empty folder"
        case 2:
            bad.symlink_to(box.place / "nowhere")
            return "the input is a link to nowhere"
        case 3:
            bad.symlink_to(bad)
            return "the input is a link to itself"
        case 4:
            bad.symlink_to(box.secret)
            return "the input is a link to another file"
        case 5:
            bad.symlink_to(source)
            return "the input is a link to a good one"
    if source.is_dir():
        bad.write_bytes(b"a,b\n1,2\n")
        return "the input is a file instead of a folder"
    bad.mkdir()
    (bad / source.name).write_bytes(source.read_bytes())
    return "the input is a folder with the file in it"


def _judged(attack: Attack, ended: Ended) -> list[str]:
    """Say what is wrong with the exit code and the words."""
    wrong = []
    if ended.hung:
        return ["no end within the limit"]
    if ended.code < 0:
        wrong.append(f"died of signal {-ended.code}")
    elif ended.code not in {0, 1, 2}:
        wrong.append(f"exit code {ended.code}")
    if "Traceback (most recent call last)" in ended.err + ended.out:
        wrong.append("a traceback")
    if SECRET in ended.err + ended.out:
        wrong.append("shows what is in another file")
    if _RAW.search(ended.err):
        wrong.append("the name of a Python exception or warning instead of a sentence")
    if _CONTROL.search(ended.err):
        wrong.append("control characters of a file on the terminal")
    lines = [line for line in ended.err.strip().split("\n") if not ALLOWED_LINES.match(line)]
    usage = ended.err.startswith("Usage: ") and len(lines) < 12
    told = usage or (attack.command == "check" and ended.code == 1)
    if (
        ended.code in {1, 2}
        and not told
        and (len(lines) != 1 or not lines[0].startswith("tribofmu: error: "))
    ):
        wrong.append(f"{len(lines)} lines instead of one sentence")
    if max((len(line) for line in lines), default=0) > SENTENCE:
        wrong.append("a sentence that is too long")
    if len(ended.out) + len(ended.err) > TEXT:
        wrong.append("prints too much")
    if ended.left:
        wrong.append(f"a process was left running: {ended.left}")
    return wrong


def _touched(
    attack: Attack, ended: Ended, before: dict[str, str], after: dict[str, str], final: Path | None, box: Box
) -> list[str]:
    """Say which files were changed that are not the output's, and what a refusal left behind."""
    own = os.path.relpath(final, box.root) if final is not None else None

    def inside(path: str) -> bool:
        return own is not None and (path == own or path.startswith(own + os.sep) or own == ".")

    gone = [p for p in before if p not in after]
    changed = [p for p in after if p in before and after[p] != before[p]]
    new = [p for p in after if p not in before]
    was_folder = own is not None and before.get(own, "folder" if own == "." else "") == "folder"
    wrong = [f"removed outside the output: {p}" for p in gone if not inside(p)]
    wrong += [f"changed outside the output: {p}" for p in changed if not inside(p)]
    parents = {os.path.normpath(p) for p in _parents(own)} if own else set()
    wrong += [
        f"written outside the output: {p}"
        for p in new
        if not inside(p) and not (ended.code == 0 and (p in parents or _kept(p, own)))
    ]
    if was_folder and not (ended.code == 0 and own == OWN.get(attack.command)):
        wrong += [f"removed in a folder of somebody else: {p}" for p in gone if inside(p)]
        wrong += [f"changed in a folder of somebody else: {p}" for p in changed if inside(p)]
        wrong += [f"added to a folder of somebody else: {p}" for p in new if inside(p)]
    elif not was_folder and own in before and (own in changed or own in gone):
        if ended.code:
            wrong.append("the old file of that name is gone though the command failed")
        elif after.get(own) == "folder":
            wrong.append("a file was replaced by a folder")
        elif own.startswith(os.path.join("a", "b", "c", "bad")) or not own.startswith(
            os.path.join("a", "b", "c")
        ):
            wrong.append("the input was overwritten")
    elif ended.code and not was_folder:
        left = [p for p in new if inside(p)]
        if attack.command not in PARTIAL or all(after[p] == "folder" for p in left):
            wrong += [f"left behind by a command that failed: {p}" for p in left]
    return wrong[:6]


def _kept(path: str, own: str | None) -> bool:
    """Return whether it is what stood in the place of the output, put beside it."""
    return own is not None and re.fullmatch(re.escape(own) + r"\.\d+(/.*)?", path) is not None


def _parents(path: str) -> list[str]:
    parts = path.split(os.sep)
    return [os.sep.join(parts[: k + 1]) for k in range(len(parts) - 1)]


def _unreadable(attack: Attack, final: Path, box: Box, limit: float) -> list[str]:
    """Give the output to the next command."""
    command = NEXT[attack.command]
    if attack.command == "predict" and final.suffix != ".csv":
        return []
    values = {"out": final, "data": box.root / "data", "next": box.place / "out-next"}
    words = [word.format_map(values) for word in command.split()]
    ended = in_child(words, box.place, box.root, limit)
    if ended.code == 0 or _HONEST.search(ended.err):
        return []
    said = _short(ended.err[-300:].strip(), box)
    return [f"its output is refused by the next command ({words[0]}: exit code {ended.code}, {said})"]


def _tidy(box: Box, after: dict[str, str]) -> None:
    """Remove what the try left; make the sandbox anew where more than its own folder changed."""
    for path in box.place.iterdir() if box.place.is_dir() else ():
        if path.name in {"system.yaml", "with_bad.yaml"} and not path.is_symlink():
            continue
        shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
    shutil.rmtree(box.root / "tmp", ignore_errors=True)
    (box.root / "tmp").mkdir(parents=True, exist_ok=True)
    if after and box.look() != box.pristine:
        box.renew()


def _short(text: str, box: Box) -> str:
    return re.sub(r"(.)\1{60,}", r"\1\1\1...", text.replace(str(box.root), "BOX"))
