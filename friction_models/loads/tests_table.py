"""The test table of a folder, changed cell by cell; the rest of the file stays as it stands there, and the old file is kept."""

from __future__ import annotations

import contextlib
import csv
import io
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from ..common.errors import InputError, check_readable, nearest, shown, unknown_name
from ..common.files import atomic_path
from ..common.locks import one_at_a_time
from .dataset import TRAINING, read_tests
from .earlier_tables import keep
from .points import load_points
from .table import encoding_of, header_of

#: What a test may be for; without a role it is for training.
ROLES = (TRAINING, "test")
#: Larger tables are not changed here.
_MAX_BYTES = 50_000_000
#: How often a table that others change meanwhile is read again.
TRIES = 20
_COLUMN = re.compile(r"[^\W\d]\w{0,59}")


class ChangedMeanwhile(InputError):
    """Another process wrote the table after this one read it."""


@dataclass(frozen=True)
class TableOfTests:
    """Rows of cells as they stand in the file of a test table.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = (Path(folder) / "tests.csv").write_text("test_id;Ra\\nt1;0,40\\nt2;0,80\\n")
    ...     table = TableOfTests.load(folder).changed([("t2", "role", "test")])
    ...     kept = table.save()
    ...     (Path(folder) / "tests.csv").read_text(), kept.name
    ('test_id;Ra;role\\nt1;0,40;\\nt2;0,80;test\\n', 'tests-001.csv')
    """

    #: Where it stands, or will stand.
    file: Path
    #: Lines over the names of the columns.
    above: tuple[str, ...]
    #: Names of the columns, perhaps their units, and one row a test.
    rows: tuple[tuple[str, ...], ...]
    separator: str = ","
    #: The file as it was read, None where there was none: `save` overwrites nothing else.
    content: bytes | None = field(default=None, repr=False, compare=False)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> TableOfTests:
        """Read the test table of a folder or a file; of a data set without one, a table with the names of its tests.

        Raises InputError: no such folder, no table and no points in it, or what `read_tests` refuses.
        """
        place = Path(path)
        file = place / "tests.csv" if place.is_dir() else place
        if place.is_dir() and not file.is_file():
            if not (place / "points.csv").is_file():
                raise InputError(
                    f"{place}: holds no tests.csv and no points.csv; allowed: a data set, a campaign, or a test table"
                )
            names = dict.fromkeys(load_points(place / "points.csv", need_mu=False)["test_id"])
            return cls(file, (), (("test_id",), *((str(name),) for name in names)))
        if file.suffix.lower() == ".parquet":
            raise InputError(f"{file}: Parquet; allowed: a test table as text, such as tests.csv")
        check_readable(file, _MAX_BYTES, "a test table")
        content = file.read_bytes()
        read_tests(file)
        above, separator = header_of(file)
        with file.open(encoding=encoding_of(file), newline="") as stream:
            lines = [stream.readline() for _ in range(above)]
            read = csv.reader(stream, delimiter=separator, skipinitialspace=True)
            rows = [tuple(cell.strip() for cell in row) for row in read if any(map(str.strip, row))]
        width = max(map(len, rows))
        # Cells that a row lacks at its end are empty ones.
        rows = [row + ("",) * (width - len(row)) for row in rows]
        return cls(file, tuple(lines), tuple(rows), separator, content)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns, without units."""
        return tuple(re.split(r"\s*\[", name, maxsplit=1)[0].strip() for name in self.rows[0])

    @property
    def tests(self) -> tuple[str, ...]:
        """Names of the tests; a row of units has none."""
        place = self.columns.index("test_id")
        return tuple(row[place] for row in self.rows[1:] if row[place])

    def cells(self) -> list[dict[str, str]]:
        """Return one dictionary a test: column and text of the cell."""
        names, place = self.columns, self.columns.index("test_id")
        return [dict(zip(names, row, strict=False)) for row in self.rows[1:] if row[place]]

    def changed(self, changes: Iterable[tuple[str, str, str]]) -> TableOfTests:
        """Return the table with other cells: (test, column, value); ``*`` in the name of a test stands for any text.

        Raises InputError: no such test, a name that can be no column, the column `test_id`, or a value that is no plain text.
        """
        columns, place = list(self.columns), self.columns.index("test_id")
        rows = [list(row) for row in self.rows]
        for test, column, value in changes:
            if column == "test_id":
                raise InputError(f"{self.file}: test_id stays as it is; allowed: another column")
            if column not in columns:
                if _COLUMN.fullmatch(column) is None:
                    raise InputError(
                        f"{self.file}: column {shown(column, 60)!r}; allowed: letters, digits and underscores"
                    )
                columns.append(column)
                rows[0].append(column)
                rows[1:] = [[*row, ""] for row in rows[1:]]
            if not (value.isprintable() and len(value) <= 500):
                raise InputError(
                    f"{self.file}: value {shown(value, 60)!r}; allowed: a text of one line, up to 500 characters"
                )
            if column == "role" and value.strip() not in (*ROLES, ""):
                raise unknown_name("role", value.strip(), ROLES, f"{self.file}: {test}")
            form = re.compile(".*".join(map(re.escape, test.split("*"))))
            hits = [row for row in rows[1:] if row[place] and form.fullmatch(row[place])]
            if not hits:
                near = nearest(test, self.tests)
                hint = f"; did you mean {near!r}?" if near else ""
                raise InputError(f"{self.file}: no test {shown(test, 60)!r}{hint}")
            for row in hits:
                row[columns.index(column)] = value.strip()
        return replace(self, rows=tuple(tuple(row) for row in rows))

    def difference(self, other: TableOfTests) -> str:
        """Return in how many cells a later table differs, and what columns it has more."""
        before = {cells["test_id"]: cells for cells in self.cells()}
        count = sum(
            before[cells["test_id"]].get(name, "") != cell
            for cells in other.cells()
            for name, cell in cells.items()
        )
        more = [name for name in other.columns if name not in self.columns]
        return f"{count} cells changed" + (f", new: {', '.join(more)}" if more else "")

    def save(self) -> Path | None:
        """Write the table, and return where the one before is kept; None where there was none.

        Nothing is written where that would be no test table (InputError), or the file is no longer the one that was read
        (ChangedMeanwhile).
        """
        # nobody may write between the last look at the file and its replacement
        with one_at_a_time(self.file.parent), atomic_path(self.file) as temporary:
            temporary.write_text(self._written(), encoding="utf-8", newline="")
            read = temporary.with_name(f"{temporary.name}.csv")
            temporary.rename(read)
            try:
                read_tests(read)
            except InputError as error:
                raise InputError(str(error).replace(str(read), str(self.file))) from None
            finally:
                read.rename(temporary)
            now = self.file.read_bytes() if self.file.is_file() else None
            if now != self.content:
                raise ChangedMeanwhile(
                    f"{self.file}: another command changed it meanwhile; allowed: the same command again"
                )
            kept = keep(self.file, self.file.parent) if now is not None else None
        return kept

    def _written(self) -> str:
        text = io.StringIO(newline="")
        text.writelines(self.above)
        csv.writer(text, delimiter=self.separator, lineterminator="\n").writerows(self.rows)
        return text.getvalue()

    def text(self) -> str:
        """Return the table for the console."""
        widths = [max(map(len, column)) for column in zip(*self.rows, strict=True)]
        padded = ([c.ljust(width) for c, width in zip(row, widths, strict=True)] for row in self.rows)
        return "\n".join("  ".join(row).rstrip() for row in padded)


def change_tests(
    path: str | os.PathLike[str], changes: Sequence[tuple[str, str, str]]
) -> tuple[TableOfTests, TableOfTests, Path | None]:
    """Change cells of the test table of a folder or a file, after other processes that do so at the same time.

    Returns the table before, the table that was written, and where the file before is kept, as `TableOfTests.save`.

    Raises InputError: as `TableOfTests`.
    """
    for _ in range(TRIES):
        table = TableOfTests.load(path)
        changed = table.changed(changes)
        with contextlib.suppress(ChangedMeanwhile):
            return table, changed, changed.save()
    raise ChangedMeanwhile(
        f"{path}: other commands change its test table all the time; allowed: one at a time"
    )


def read_change(text: str) -> tuple[str, str, str]:
    """Return (test, column, value) of a change as the command line writes it.

    Raises InputError: another form.

    Examples
    --------
    >>> read_change("t01:role=test"), read_change("*:Ra=")
    (('t01', 'role', 'test'), ('*', 'Ra', ''))
    """
    found = re.fullmatch(r"(.+?):([^\W\d]\w*)=(.*)", text, re.DOTALL)
    if found is None:
        raise InputError(f"--set {shown(text, 80)!r}; allowed: TEST:COLUMN=VALUE, such as t01:role=test")
    return found[1], found[2], found[3]
