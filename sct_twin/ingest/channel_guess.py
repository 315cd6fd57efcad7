"""Draft of a channel map: guesses which column is which channel, from German and English names and units."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from friction_models.common import InputError

from ..readers import RawTable
from ..readers.header import is_unit
from ..records.channels import CHANNELS, MOTION
from ..records.units import channel_conversion

#: How sure a name is: of this channel for certain, of this kind and no other known, or one of several it may be.
_SURE, _PLAIN, _MAYBE = 3, 2, 1

#: Words of a name, joined by blanks, umlauts written out. A name that is no measured channel of the plate or the cells
#: (set values, extremes, coefficients) is none of these.
_NEVER = (
    r"\b(soll\w*|set|setpoint|target|nominal|cmd|command\w*|ref|max|min|mean|mittel\w*|std|limit|grenz\w*)\b"
    r"|reibwert|reib\w*(zahl|koeff)|coeff|\bcof\b|\bmue?\b|moment|torque|arbeit|energ|leistung|power"
    r"|spannung|stress|frequenz|frequency|\brate\b|drehzahl"
)
_PLATE = r"platte|plate|schlitten|sledge|slider?\b|gleit|sliding"
_PUNCH = r"stempel|punch|presse|\bpress\b|stoessel|\bram\b|stauch|upset"
_NAMES: dict[str, tuple[tuple[int, str], ...]] = {
    "t": (
        (0, r"uhrzeit|datum|\bdate\b|clock|zeitstempel|gleitzeit"),
        (_PLAIN, r"^(t|zeit|time)\b|\b(mess)?zeit\b|\btime\b|\btimestamps?\b|^t (s|ms|sec)$"),
    ),
    "F_n": (
        (_SURE, r"normal ?(kraft|force|load|last)|\bf ?(n|z)\b|\b(kraft|force|last|load) ?[nz]\b|\b[nz] ?(kraft|force)\b"),
        (_SURE, r"axial ?(kraft|force|load)|(anpress|druck|press|stempel|stauch|vertikal)kraft|(vertical|punch|press) force"),
        (_SURE, r"^(f|kraft|force) (norm\w*|ax\w*|vert\w*)$"),
        (_PLAIN, r"\bload\b(?! cell)|\blast\b"),
        (_MAYBE, r"kraft|force|\bload cell|\bkmd\b|^f\b"),
    ),
    "F_r": (
        (_SURE, r"reib\w*kraft|friction ?force|\bf ?(r|t|x|reib\w*|fric\w*)\b|\b(kraft|force) ?[rtx]\b|\b[x] ?(kraft|force)\b"),
        (_SURE, r"(tangential|quer|scher|schub|zug|horizontal|schiebe)kraft|(tangential|shear|lateral|pull|drive) ?force"),
        (_SURE, r"^(kraft|force) (tang\w*|hor\w*|quer)$|^(friction|reibung)$"),
        (_MAYBE, r"kraft|force|\bload cell|\bkmd\b|^f\b"),
    ),
    "s": (
        (0, r"bewegung"),
        (_MAYBE, rf"({_PUNCH}).*(weg|pos|hub|stroke|disp)|(weg|pos\w*|hub|stroke|disp\w*).*({_PUNCH})"),
        (_MAYBE, r"\bhub\b|\bstroke\b|^distance\b|^strecke\b"),
        (_SURE, rf"({_PLATE}).*(weg|pos|disp|travel|distance|strecke)|(weg|pos\w*|disp\w*|travel|^s|^x) .*({_PLATE})|gleitweg|\bx plate\b"),
        (_PLAIN, r"\b(mess)?weg(aufnehmer|sensor|e)?\b|\bpos\w*|\bdisp\w*|verschiebung|verfahrweg|\btravel\b|^s\b|^x\b|\bpath\b"),
    ),
    "a": ((_PLAIN, r"\bbeschl\w*|\bacc\w*|^a\b|\w+beschleunigung"),),
    "T_plate": (
        (0, r"prob(e|en)|specimen|sample|umgebung|ambient|raum|\broom\b|luft|\bair\b|\boel|\boil\b|kuehl|cool|motor|werkstueck|workpiece"),
        (_MAYBE, r"werkzeug|\btool\b|stempel|punch|matrize|\bdie\b|ofen|furnace|oven|heiz|heat"),
        (_SURE, rf"({_PLATE}).*(?<!s)(temp|thermo)|((?<!s)temp\w*|thermo\w*|^t|^tc|^te) .*({_PLATE})|^t ?plat\w*$"),
        (_PLAIN, r"(?<!s)temp\w*|thermo\w*|^tc\b|^te\b|^t\b"),
    ),
    "v": (
        (0, r"\brot\w*|\brps\b|\brpm\b"),
        (_MAYBE, rf"({_PUNCH}).*(geschw|speed|vel)|(geschw\w*|speed|vel\w*|^v) .*({_PUNCH})"),
        (_SURE, rf"({_PLATE}).*(geschw|speed|vel)|(geschw\w*|speed|vel\w*|^v) .*({_PLATE})"),
        (_PLAIN, r"geschw\w*|\bspeed\b|\bvel\w*|^v\b"),
    ),
}  # fmt: skip
#: Stands for a unit that only the laboratory knows.
_ASK = "?"
#: What to do where no column is found; the others are needed.
_WITHOUT = {
    "a": "it can be missing",
    "T_plate": "T_tool has to stand in the test table, or below metadata",
    "s": "position or speed is needed",
    "v": "position or speed is needed",
}
UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss"})


@dataclass(frozen=True)
class Guess:
    """A channel: the column it is (None where that is open), and the columns it may be."""

    quantity: str
    column: str | None
    candidates: tuple[str, ...]


def guess_channels(table: RawTable) -> list[Guess]:
    """Return for every channel the column it is, or the columns of which one may be it.

    A column is taken where its name is the only one that says so; two that say the same, and names that may mean
    several things (`Kraft 1`), are left to the user.
    """
    free = [str(name) for name in table.frame.columns]
    scores = {
        quantity: {
            name: _score(quantity, name_and_unit(name)[0])
            for name in free
            if _fits(quantity, _unit(table, name))
        }
        for quantity in _NAMES
    }
    taken: dict[str, str] = {}
    for quantity, names in scores.items():
        best = _best(names)
        # No other channel claims the column more surely.
        if len(best) == 1 and names[best[0]] >= _PLAIN:
            surest = max(others.get(best[0], 0) for others in scores.values())
            if surest <= names[best[0]]:
                taken[quantity] = best[0]
    guesses = []
    for quantity, names in scores.items():
        if quantity in taken and list(taken.values()).count(taken[quantity]) == 1:
            guesses.append(Guess(quantity, taken[quantity], (taken[quantity],)))
            continue
        rest = {name: score for name, score in names.items() if name not in taken.values()}
        guesses.append(Guess(quantity, None, tuple(_best(rest))))
    return guesses


def name_and_unit(name: str) -> tuple[str, str]:
    """Return what ``sliding_distance_um`` and ``v_mm_s`` say: a name and a unit ('' without one)."""
    parts = name.split("_")
    for count in (2, 1):
        head, tail = "_".join(parts[:-count]), "/".join(parts[-count:])
        # F_N is a normal force and not a force in newtons.
        if head and tail and is_unit(tail) and (head, tail) != ("F", "N"):
            return head, tail
    return name, ""


def _unit(table: RawTable, name: str) -> str:
    return table.units.get(name, "") or name_and_unit(name)[1]


def _words(name: str) -> str:
    """Return a name in small letters, words apart, umlauts written out: ``F_N,Soll`` and ``NormalForce`` alike."""
    apart = re.sub(r"(?<=[a-zäöüß])(?=[A-ZÄÖÜ])|(?<=[a-zA-Z])(?=\d)|(?<=\d)(?=[a-zA-Z])", " ", name)
    return " ".join(re.findall(r"[^\W_]+", apart.lower().translate(UMLAUTS)))


def _score(quantity: str, name: str) -> int:
    """Return how sure a name is, by the first of the channel's forms that it has."""
    words = _words(name)
    if re.search(_NEVER, words) or (quantity == "T_plate" and name == "t"):
        return 0
    if quantity == "t" and name == "T":
        return _MAYBE
    return next((score for score, form in _NAMES[quantity] if re.search(form, words)), 0)


def _best(scores: dict[str, int]) -> list[str]:
    top = max(scores.values(), default=0)
    return [name for name, score in scores.items() if score == top and top > 0]


def _fits(quantity: str, unit: str) -> bool:
    if not unit:
        return True
    try:
        channel_conversion(quantity, unit)
    except InputError:
        return False
    return True


def draft(table: RawTable) -> str:
    """Return a `channels.yaml` to start from; what is open stands in it as a question with the columns it is about."""
    channels: dict[str, dict[str, str]] = {}
    questions: list[str] = []
    blank = False
    guesses = guess_channels(table)
    has_motion = any(guess.column for guess in guesses if guess.quantity in MOTION)
    for guess in guesses:
        entries = {name: _entry(guess.quantity, table, name) for name in guess.candidates}
        if guess.column is not None:
            channels |= entries
        elif entries:
            names = " or ".join(map(repr, entries))
            asked = f"is it {names}? Take the # from " + (
                "one line" if len(entries) > 1 else "the line if it is"
            )
            questions.append(f"  # {guess.quantity} ({CHANNELS[guess.quantity].meaning}): {asked}")
            questions += [f"  # {line}" for line in _lines(entries)]
        elif guess.quantity not in MOTION or not has_motion:
            without = _WITHOUT.get(guess.quantity, "it is needed")
            questions.append(
                f"  # no column found for {guess.quantity} ({CHANNELS[guess.quantity].meaning}): {without}"
            )
        blank = blank or any(entry.get("unit") == _ASK for entry in entries.values())
    text = ["channels:", *(f"  {line}" for line in _lines(channels)), *questions]
    if blank:
        text.append(f"  # the file names no unit of some columns: write it in place of {_ASK}")
    used = {name for guess in guesses for name in guess.candidates}
    unused = [str(name) for name in table.frame.columns if str(name) not in used]
    if unused:
        text.append(f"# not used: {', '.join(unused)}")
    text += [
        "# moving_mass: 25.0         # kg between force cell and contact, 0 without this line",
        "# metadata: {T_tool: 20.0}  # what all tests share, unless the test table says it",
    ]
    return "\n".join([*text, "phases: detect"])


def _entry(quantity: str, table: RawTable, name: str) -> dict[str, str]:
    """Return the entry of a column; a unit that the file does not state is that of the name, or asked for."""
    stated = table.units.get(name, "")
    return {"quantity": quantity, **({} if stated else {"unit": name_and_unit(name)[1] or _ASK})}


def _lines(channels: dict[str, dict[str, str]]) -> Iterator[str]:
    """Return entries of a channel map, one a line."""
    import yaml

    for name, entry in channels.items():
        line: str = yaml.safe_dump({name: entry}, default_flow_style=True, allow_unicode=True, width=10_000)
        yield line.strip()[1:-1]
