"""What a project holds, gathered for the page of its story. Every file is one of others: what cannot be read is said."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from friction_models.common import InputError
from friction_models.common.errors import shown
from friction_models.common.files import read_json
from friction_models.loads.contract import with_unit

from ..report.pages.story import Chapter, Loop, Measurements, Packed, ProjectStory
from ..report.reading import read_page
from .commands import short
from .commands.fmus import last_check
from .commands.models import diagnosis_files
from .model_findings import noise_floor, rounds_of
from .project import HISTORY, Project, history
from .project.history import Story

T = TypeVar("T")
#: Sections of each kind of report that the story takes, by the beginning of their anchors.
_DIAGNOSIS = ("verdict", "response", "budget")
_COMPARISON = ("errors", "parity")
_FORMING = ("runs", "run-forces", "force-errors", "level-errors", "force-curves")
_COVERAGE = ("loads",)


def story_of(folder: Path) -> ProjectStory:
    """Return the story of a project folder; raises InputError for another folder."""
    return _Teller(Project.open(folder)).told()


class _Teller:
    """Reads a project; remembers what could not be read."""

    def __init__(self, project: Project) -> None:
        self.project = project
        self.lines = history.read(project.root / HISTORY)
        self.problems: list[str] = []

    def told(self) -> ProjectStory:
        reports = sorted(self.project.reports(), key=lambda p: p.name)
        loops = _loops(self.lines)
        return ProjectStory(
            self.project.title,
            self._each(self.project.data_sets(), self._measured),
            self._diagnoses(loops, reports),
            [loop for loop in map(self._loop, loops) if loop.rounds],
            self._chapters(reports, "comparison-", "On ", _COMPARISON),
            self._each(self.project.fmus(), self._packed),
            self._chapters(reports, "forming-", "Forming ", _FORMING)
            + self._chapters(reports, "coverage-", "Tested loads: ", _COVERAGE),
            self._commands(),
            self.problems,
        )

    def _each(self, files: list[Path], read: Callable[[Path], T]) -> list[T]:
        found = []
        for file in files:
            try:
                found.append(read(file))
            except (InputError, OSError) as error:
                self.problems.append(f"{self.project.relative(file)}: {shown(error, 300)}")
        return found

    def _measured(self, path: Path) -> Measurements:
        from friction_models.loads import LOAD_NAMES, MU, DataSet, not_measured
        from friction_models.loads.dataset import roles_of

        data = DataSet.load(path, need_mu=False)
        points = data.points
        tests = points["test_id"].nunique() if "test_id" in points.columns else 0
        rows = [("tests", f"{tests}"), ("points", f"{len(points)}")]
        if data.tests is not None and "role" in data.tests.columns:
            roles = roles_of(data.tests["role"]).value_counts(sort=False)
            rows.append(("roles", ", ".join(f"{n} {role}" for role, n in sorted(roles.items()))))
        for name in (*LOAD_NAMES, MU.name):
            if name in points.columns:
                low, middle, high = (float(v) for v in points[name].quantile([0.0, 0.5, 1.0]))
                rows.append((with_unit(name), f"{low:.4g} to {high:.4g}, median {middle:.4g}"))
        lacking = not_measured(points.columns)
        notes = [f"not measured: {', '.join(lacking)}"] if lacking else []
        return Measurements(short(self.project.relative(path)), rows, [*notes, *data.notes], data.synthetic)

    def _diagnoses(self, loops: list[Story], reports: list[Path]) -> list[Chapter]:
        """Return the answers about the models of the loops, in their order; without a loop all that there are."""
        told = [diagnosis_files(loop.data, r.model)[1] for loop in loops for r in loop.rounds]
        files = [p for name in told for p in reports if self.project.relative(p) == name]
        return self._chapters(files or reports, "diagnosis-", "", _DIAGNOSIS)

    def _chapters(
        self, reports: list[Path], prefix: str, words: str, sections: tuple[str, ...]
    ) -> list[Chapter]:
        files = [p for p in reports if p.name.startswith(prefix)]
        return self._each(
            files, lambda p: Chapter(words + p.stem.removeprefix(prefix), read_page(p), sections)
        )

    def _loop(self, story: Story) -> Loop:
        rounds = self._rounds(story)
        return Loop(short(story.data), rounds, self._floor(story) if rounds else None)

    def _rounds(self, story: Story) -> list[Mapping[str, Any]]:
        """Return the errors round by round, which the card of the model in hand keeps."""
        if len(story.rounds) < 2:
            return []
        try:
            return rounds_of(self.project.inside(f"{story.model}/card.json"))
        except (InputError, OSError) as error:
            self.problems.append(f"{shown(story.model, 80)}: {shown(error, 300)}")
            return []

    def _floor(self, story: Story) -> float | None:
        try:
            return noise_floor(read_json(self.project.inside(diagnosis_files(story.data, story.model)[0])))
        except InputError:
            return None

    def _packed(self, path: Path) -> Packed:
        name = self.project.relative(path)
        said, _ = last_check(self.lines, name)
        content = path.read_bytes()
        digest = hashlib.sha256(content).hexdigest()
        return Packed(name.removeprefix("fmus/"), len(content) / 1000, digest, said)

    def _commands(self) -> list[tuple[str, str, str]]:
        rows = []
        for line in self.lines:
            if line["event"] == history.STARTED:
                continue
            time = str(line.get("time", ""))[:19].replace("T", " ")
            if line["event"] == history.ENDED:
                what = shown(line.get("command", ""), 2000)
            else:
                what = f"{shown(line['event'], 40)} {shown(history.about(line), 200)}".strip()
            rows.append((time, what, history.outcome(line)))
        return rows


def _loops(lines: list[dict[str, Any]]) -> list[Story]:
    """Return for each data set the last loop that led to an addition, and the one in hand."""
    found = [loop for loop in Story.loops(lines) if loop.data]
    kept = {loop.data: loop for loop in found if len(loop.rounds) > 1}
    last = found[-1] if found else None
    return [loop for loop in found if loop is kept.get(loop.data) or (loop is last and loop.data not in kept)]
