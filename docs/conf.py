"""The site of the documentation (`make docs`): the Markdown pages of the repository, and a reference that is made from docstrings.

The pages are read as they stand, from the root of the repository, so that they can also be read where the repository is hosted.
`_toc.yml` orders them. What `reference/` holds is written anew by each build.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import inspect
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

from orchestrator.cli.app import command as command_line

if TYPE_CHECKING:
    from sphinx.application import Sphinx

HERE = Path(__file__).parent
#: Packages of the reference: all their public names.
PACKAGES = (
    "friction_models",
    "friction_models.loads",
    "friction_models.effects",
    "friction_models.discovery",
    "friction_models.training",
    "friction_models.cards",
    "sct_twin",
    "sct_twin.virtual_lab",
    "forming",
    "fmus",
    "orchestrator",
)

project, author, release = "tribofmu", "the authors of tribofmu", importlib.metadata.version("tribofmu")
copyright = "MIT licence"
extensions = [
    "myst_parser",
    "sphinx_external_toc",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
]
external_toc_path = "docs/_toc.yml"
include_patterns = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/**.md"]
exclude_patterns = [".venv", ".git", "build", "dist", "tests", "benchmarks", "**/__pycache__"]

myst_heading_anchors = 4
default_role = "code"
autodoc_typehints = "signature"
autodoc_class_signature = "separated"
napoleon_numpy_docstring, napoleon_google_docstring = True, False
napoleon_use_rtype = False
# Words in the types of arguments that several classes have as attributes are no links.
suppress_warnings = ["ref.python"]

# MathML, which browsers draw themselves: the usual script would be loaded from elsewhere.
html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = "tribofmu"
html_static_path = ["static"]
# The first page lies in docs/, as in the repository: this one leads to it.
html_extra_path = ["root"]
html_css_files = ["site.css"]
# A page opened as a file may not read others for excerpts; the titles found are enough.
html_show_search_summary = False
html_show_sourcelink = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_nav_level": 1,
    "navbar_align": "left",
    "header_links_before_dropdown": 5,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
copybutton_prompt_text = ">>> "


def write_reference(app: Sphinx, config: object) -> None:
    """Write a page for every package and one for the commands."""
    folder = HERE / "reference"
    folder.mkdir(exist_ok=True)
    for name in PACKAGES:
        _write(folder / f"{name}.md", _package_page(name))
    _write(folder / "commands.md", _commands_page())


def _write(file: Path, text: str) -> None:
    """Write a page that has changed; the builder skips the others."""
    if not file.is_file() or file.read_text(encoding="utf-8") != text:
        file.write_text(text, encoding="utf-8")


def _package_page(name: str) -> str:
    module = importlib.import_module(name)
    about = (inspect.getdoc(module) or "").partition("\n")[0]
    parts = [f"# {name}\n\n{about}\n"]
    for public in sorted(module.__all__, key=str.lower):
        found = getattr(module, public)
        kind = "autoclass" if inspect.isclass(found) else "autofunction" if inspect.isroutine(found) else ""
        if not kind or getattr(found, "__doc__", None) is None:
            continue
        # A class is described where it lives most plainly: in the first package that names it.
        elsewhere = next(p for p in PACKAGES if public in importlib.import_module(p).__all__)
        if elsewhere != name and getattr(importlib.import_module(elsewhere), public) is found:
            parts.append(f"## {public}\n\nSee [{elsewhere}.{public}](#{elsewhere}.{public}).\n")
            continue
        members = (
            "\n   :members:\n   :exclude-members: set_fit_request, set_score_request, set_predict_request"
            if kind == "autoclass"
            else ""
        )
        parts.append(f"## {public}\n\n```{{eval-rst}}\n.. {kind}:: {name}.{public}{members}\n```\n")
    return "\n".join(parts)


def _commands_page() -> str:
    root = command_line()
    context = click.Context(root, info_name="tribofmu")
    parts = ["# Commands\n\nWhat `--help` of each command says.\n"]
    for name in root.list_commands(context):
        command = root.get_command(context, name)
        parts += _command(command, f"tribofmu {name}") if command else []
    return "\n".join(parts)


def _command(command: Any, called: str) -> list[str]:
    if hasattr(command, "commands"):
        inner = [
            part
            for name in sorted(command.commands)
            for part in _command(command.commands[name], f"{called} {name}")
        ]
        return [f"## {called}\n\n{command.help}\n", *inner]
    rows = [
        f"| {' '.join(f'`{o}`' for o in (*p.opts, *p.secondary_opts))} | {(p.help or '').replace('|', '/')} |"
        for p in command.params
        if getattr(p, "help", None)
    ]
    table = "\n".join(["| option | meaning |", "|---|---|", *rows]) if rows else ""
    return [
        f"## {called}\n\n{command.help}\n\n{table}\n",
        f"```console\n{command.epilog}\n```\n" if command.epilog else "",
    ]


def setup(app: Sphinx) -> None:
    """Have the reference written before the pages are looked for, and formulas as MathML."""
    app.connect("config-inited", write_reference)
    app.add_html_math_renderer("mathml", (_formula, None), (_formula, None))


def _formula(translator: Any, node: nodes.Element) -> None:
    translator.body.append(tex2mathml(node.astext(), as_block=isinstance(node, nodes.math_block)))
    raise nodes.SkipNode
