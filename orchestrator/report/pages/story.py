"""The story of a project: what was measured, what the models missed, what was added, packed and formed, on one page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from friction_models.common.markup import bullets, escape, paragraph, table
from friction_models.common.wording import listed

from ..charts.rounds import rounds_chart
from ..parts.cards import INTERVALS, chance, in_numbers, judged
from ..parts.chart import figure, figure_again
from ..parts.page import Page
from ..reading import ReadFigure, ReadPage

#: Most commands that are listed.
COMMANDS = 400


@dataclass(frozen=True)
class Measurements:
    """A data set in numbers: `rows` are quantity and what was found, `notes` plain sentences."""

    name: str
    rows: Sequence[tuple[str, str]]
    notes: Sequence[str] = ()
    synthetic: bool = False


@dataclass(frozen=True)
class Chapter:
    """A report of the project, and which of its sections the story takes (all that begin so)."""

    heading: str
    page: ReadPage
    sections: tuple[str, ...]


@dataclass(frozen=True)
class Packed:
    """An FMU; `checked` says how its last check ended, empty where there was none."""

    name: str
    kilobytes: float
    sha256: str
    checked: str = ""


@dataclass(frozen=True)
class Loop:
    """The additions to a model on the data set that is called `data`."""

    data: str
    #: Errors before and after each addition, as the card of the last model holds them.
    rounds: Sequence[Mapping[str, Any]]
    #: Noise floor [mu].
    floor: float | None = None


@dataclass(frozen=True)
class ProjectStory:
    """What a project holds, as its page tells it."""

    title: str
    measurements: Sequence[Measurements] = ()
    diagnoses: Sequence[Chapter] = ()
    #: One a data set, with a round at least.
    loops: Sequence[Loop] = ()
    comparisons: Sequence[Chapter] = ()
    fmus: Sequence[Packed] = ()
    forming: Sequence[Chapter] = ()
    #: Time, command line or decision, how it ended.
    commands: Sequence[tuple[str, str, str]] = ()
    problems: Sequence[str] = field(default_factory=tuple)

    @property
    def synthetic(self) -> bool:
        """Whether any number rests on a virtual laboratory."""
        chapters = (*self.diagnoses, *self.comparisons, *self.forming)
        return any(m.synthetic for m in self.measurements) or any(c.page.synthetic for c in chapters)

    @property
    def headline(self) -> str:
        """Return what came out, in one line."""
        if self.loops:
            last = self.loops[-1]
            before, after = last.rounds[0]["before"]["rmse"], last.rounds[-1]["after"]["rmse"]
            added = ", ".join(str(name) for entry in last.rounds for name in entry["added"])
            said = "fell" if after < before else "went"
            where = f" on {last.data}" if len(self.loops) > 1 else ""
            return f"{added} added: the RMS error of mu{where} {said} from {before:.4f} to {after:.4f}"
        return self.diagnoses[-1].page.title if self.diagnoses else self.title


def story_page(story: ProjectStory) -> str:
    """Return the HTML of a project's story."""
    told = [
        (len(story.measurements), "data set", "data sets"),
        (sum(len(loop.rounds) for loop in story.loops), "accepted addition", "accepted additions"),
        (len(story.fmus), "FMU", "FMUs"),
        (len(story.forming), "page on forming", "pages on forming"),
    ]
    counts = [f"{n} {one if n == 1 else several}" for n, one, several in told if n]
    page = Page(
        story.headline,
        "tribofmu story",
        escape(f"{story.title}: {', '.join(counts) or 'nothing was measured or made yet'}."),
        story.synthetic,
    )
    if story.measurements:
        page.add("measurements", "What was measured", *(_measured(m) for m in story.measurements))
    if story.diagnoses:
        page.add("missing", "What the models missed", *_chapters(story.diagnoses, "d"))
    if story.loops:
        page.add("rounds", "Round by round", *_rounds(story.loops))
    if story.comparisons:
        page.add("models", "Models beside each other", *_chapters(story.comparisons, "c"))
    if story.forming:
        page.add("forming", "In forming", *_chapters(story.forming, "f"))
    if story.fmus:
        rows = [(f.name, f"{f.kilobytes:.0f}", f.checked or "not checked", f.sha256[:16]) for f in story.fmus]
        page.add(
            "fmus",
            "FMUs to take away",
            table(["FMU", "size [kB]", "check", "SHA-256, first 16"], rows, numeric=(1,)),
        )
    if story.problems:
        page.add("problems", "What could not be read", bullets(story.problems))
    if story.commands:
        page.add("commands", "How it was made", *_commands(story.commands))
    return page.render()


def _measured(m: Measurements) -> str:
    return f"<h3>{escape(m.name)}</h3>" + table(["quantity", "found"], m.rows, narrow=True) + bullets(m.notes)


def _chapters(chapters: Sequence[Chapter], prefix: str) -> list[str]:
    """Return the chosen sections of reports; what they hold was written anew and escaped as it was read."""
    parts = []
    for number, chapter in enumerate(chapters, 1):
        parts.append(f"<h3>{escape(chapter.heading)}</h3>")
        parts.append(f"<p><strong>{escape(chapter.page.title)}</strong></p><p>{chapter.page.lead}</p>")
        for k, section in enumerate(chapter.page.sections):
            if not section.anchor.startswith(chapter.sections):
                continue
            for part in section.parts:
                if isinstance(part, ReadFigure):
                    name = f"{prefix}{number}-{k}"
                    parts.append(figure_again(name, part.data, part.layout, part.caption, part.description))
                else:
                    parts.append(part)
    return parts


def _rounds(loops: Sequence[Loop]) -> list[str]:
    """Return the staircase of falling error of each data set and its numbers."""
    # It brings all models, for which a project without rounds does not wait.
    from friction_models.discovery.refinement_rounds import round_notes

    parts = []
    for number, loop in enumerate(loops, 1):
        first, last = loop.rounds[0], loop.rounds[-1]
        rows = [
            (
                listed(str(name) for name in entry["added"]),
                *in_numbers(entry, "rmse"),
                f"{100 * (entry['after']['rmse'] / entry['before']['rmse'] - 1):+.0f} %",
                chance(entry),
                str(entry["judged_by"]),
            )
            for entry in loop.rounds
        ]  # fmt: skip
        caption = "RMS error of mu on tests that the fit did not see, at the start and after each addition; bars: 95 % intervals over tests."
        name = "rounds" if number == 1 else f"rounds-{number}"
        parts += [
            f"<h3>{escape(loop.data)}</h3>" if len(loops) > 1 else "",
            judged(first, last),
            bullets([note for entry in loop.rounds for note in round_notes(entry)]),
            figure(name, rounds_chart(loop.rounds, loop.floor), caption, "Error after each round, falling as a staircase."),
            table(
                ["added", "RMSE of mu before [95 %]", "after [95 %]", "fall [95 %]", "change", "the change is", "judged by"],
                rows, numeric=(1, 2, 3, 4), caption=INTERVALS,
            ),
        ]  # fmt: skip
    return parts


def _commands(commands: Sequence[tuple[str, str, str]]) -> list[str]:
    shown = commands[-COMMANDS:]
    left = len(commands) - len(shown)
    return [
        paragraph(
            "The commands, in the order in which they ran: pasted into a shell in the project folder they give the same files."
            + (f" {left} earlier ones are left out." if left else "")
        ),
        table(["time (UTC)", "command or decision", "outcome"], shown),
    ]
