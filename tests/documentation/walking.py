"""Runs a page of the documentation as a reader would: writes its files, runs its commands and its code, in order.

- A block ``python`` is run; all blocks of a page share their names. A picture right behind it is that of its last line.
- A block ``sh`` holds command lines of `tribofmu`. A picture right behind it is the last page that they wrote.
- A block ``text`` behind either stands in what was said; ``...`` is any text.
- A block behind a comment ``<!-- file: NAME -->`` is written to that file; files that the page links to lie in the folder.

``python -m tests.documentation.walking`` runs all such pages and draws their pictures anew (needs Chromium).
"""

from __future__ import annotations

import ast
import contextlib
import doctest
import io
import re
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from orchestrator.cli.main import run

DOCS = Path(__file__).parents[2] / "docs"
#: Pages that are run as they stand.
WALKED = [*sorted(p for p in (DOCS / "tutorials").glob("*.md") if p.name != "index.md"), DOCS / "gallery.md"]
_BLOCK = re.compile(
    r"(?:<!-- file: (?P<file>\S+) -->\n+)?^```(?P<kind>\w+)\n(?P<text>.*?)^```$|^!\[[^]]*\]\((?P<picture>[^)]+)\)",
    re.DOTALL | re.MULTILINE,
)
_LINK = re.compile(r"(?<!!)\[[^]]*\]\(([^)#]+)\)")
_SAYS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
#: Size of a picture of a page, and of a figure [px].
PAGE, FIGURE = (1180, 860), (900, 520)


@dataclass
class Walk:
    """What a page has done so far: its names, what it said last, and what a picture behind it would show."""

    page: Path
    folder: Path
    names: dict[str, Any] = field(default_factory=lambda: {"__name__": "page"})
    said: str = ""
    shown: Any = None
    pictures: dict[Path, go.Figure | Path] = field(default_factory=dict)

    def whole(self) -> None:
        """Run the page in its folder, which is the present one."""
        text = self.page.read_text(encoding="utf-8")
        for link in _LINK.findall(text):
            source = self.page.parent / link
            if "://" not in link and source.suffix not in {".md", ""}:
                shutil.copy(source, self.folder)
        for block in _BLOCK.finditer(text):
            self._block(block)

    def _block(self, block: re.Match[str]) -> None:
        content = block["text"]
        if block["picture"]:
            assert isinstance(self.shown, go.Figure | Path), f"{self.where(block)}: nothing to draw before it"
            self.pictures[self.page.parent / block["picture"]] = self.shown
        elif block["file"]:
            (self.folder / block["file"]).write_text(content, encoding="utf-8")
        elif block["kind"] == "python":
            self._says(lambda: self._python(content))
        elif block["kind"] == "sh":
            self._says(lambda: self._commands(content, self.where(block)))
        elif block["kind"] == "text":
            wanted = f"...{content.strip()}...\n"
            fits = doctest.OutputChecker().check_output(wanted, self.said, _SAYS)
            assert fits, f"{self.where(block)}: not said; it said\n{self.said}"

    def where(self, block: re.Match[str]) -> str:
        """Return page and line of a block."""
        return f"{self.page.name}:{block.string.count(chr(10), 0, block.start()) + 1}"

    def _says(self, act: Any) -> None:
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(io.StringIO()):
            act()
        self.said = said.getvalue()

    def _python(self, text: str) -> None:
        tree = ast.parse(text)
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, self.page.name, "exec"), self.names)
        self.shown = None
        if last is not None:
            code = compile(ast.Expression(last.value), self.page.name, "eval")
            self.shown = eval(code, self.names)  # noqa: S307
            if self.shown is not None and not isinstance(self.shown, go.Figure):
                print(self.shown)

    def _commands(self, text: str, where: str) -> None:
        for line in text.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            if not words:
                continue
            assert words[0] == "tribofmu", f"{where}: {line}"
            said = io.StringIO()
            with contextlib.redirect_stderr(said):
                code = run(words[1:])
            assert code == 0, f"{where}: {line}: {said.getvalue()}"
            pages = [self.folder / w for w in words if w.endswith(".html")]
            self.shown = pages[-1] if pages else None


@contextlib.contextmanager
def walked(page: Path, folder: Path) -> Iterator[Walk]:
    """Run a page in a folder; on leaving the folder is no longer the present one."""
    with contextlib.chdir(folder):
        sys.path.insert(0, str(folder))
        try:
            walk = Walk(page, folder)
            walk.whole()
            yield walk
        finally:
            sys.path.remove(str(folder))


def draw(pictures: dict[Path, go.Figure | Path]) -> None:
    """Draw figures as SVG and pages as PNG, by Chromium."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        for place, shown in pictures.items():
            place.parent.mkdir(exist_ok=True)
            width, height = FIGURE if isinstance(shown, go.Figure) else PAGE
            tab = browser.new_page(viewport={"width": width, "height": height})
            if isinstance(shown, go.Figure):
                tab.set_content("<div id='figure'></div>")
                tab.add_script_tag(content=get_plotlyjs())
                svg = tab.evaluate(
                    "([figure, width, height]) => Plotly.toImage(JSON.parse(figure), {format: 'svg', width, height})",
                    [shown.to_json(), width, height],
                )
                place.write_text(
                    tab.evaluate("u => decodeURIComponent(u.split(',', 2)[1])", svg) + "\n", "utf-8"
                )
            else:
                tab.goto(shown.as_uri())
                tab.wait_for_load_state("networkidle")
                tab.screenshot(path=place)
            tab.close()
        browser.close()


def main() -> None:
    """Run the named pages, or all, and draw their pictures."""
    wanted = sys.argv[1:]
    for page in WALKED:
        if wanted and page.stem not in wanted:
            continue
        with tempfile.TemporaryDirectory() as place, walked(page, Path(place)) as walk:
            draw(walk.pictures)
        print(page.name, *(p.name for p in walk.pictures))


if __name__ == "__main__":
    main()
