"""The report of a single run: force over stroke, the loads in the contact, timing, manifest."""

from __future__ import annotations

from pathlib import Path

from friction_models.common import InputError
from friction_models.common.markup import bullets, escape, table

from ...cosim.local_errors import stated_errors
from ...cosim.run_folders import Run
from ..charts.runs import run_force_chart, run_loads_caption, run_loads_chart
from ..parts.page import Page
from ..sections.stated_errors import stated_errors_table

ERRORS_NOT_STATED = (
    "<p>How far these loads may be off because of the size of the elements was not asked for: <code>tribofmu simulate "
    "--local-errors</code> runs the system once more with smaller ones and states it here.</p>"
)


def run_page(folder: Path) -> str:
    """Return the HTML of a run folder."""
    run = Run.load(folder, stopped=True)
    manifest = run.manifest
    forms = any(label.endswith(".force") for label in run.values)
    page = Page(
        title=f"{run.name}: largest force {run.force_curve().force.max():.1f} kN" if forms else run.name,
        kicker="tribofmu run",
        lead=f"{manifest['steps']} steps of {manifest['communication_step']:g} s in the mode <code>{escape(manifest['mode'])}</code>, "
        f"{manifest['timing_s']['total']:.1f} s of computing."
        + ("" if run.complete else f" <strong>Stopped: {escape(run.message)}.</strong>"),
        synthetic=run.synthetic,
    )
    if warnings := manifest.get("warnings"):
        page.add("notes", "Read this with care", bullets(map(str, warnings)))
    if forms:
        title, caption = "Force over stroke", "Punch force over stroke, unfiltered."
        page.plot("force", title, run_force_chart(run.force_curve()), caption, "Force over stroke.")
    if fields := _fields(run):
        page.add("fields", "Fields", fields)
    if (chart := run_loads_chart(run)) is not None:
        shown = run_loads_caption(run)
        page.plot(
            "contact", "Loads in the contact", chart, shown, "Loads and friction in the contact over time.",
            stated_errors_table({run.name: stated_errors(run)}) or _not_stated(run),
        )  # fmt: skip
    page.add("manifest", "Manifest", _manifest(run))
    return page.render(f"tribofmu {escape(manifest['versions']['tribofmu'])}")


def _not_stated(run: Run) -> str:
    """Return how to have the errors of the loads stated, where a forming process says which points touch."""
    return ERRORS_NOT_STATED if any(label.endswith(".active") for label in run.values) else ""


def _fields(run: Run) -> str:
    """Return the fields that `simulate --fields` saved, as animations of 2.5 MB in all."""
    if not (run.folder / "fields").is_dir():
        return ""
    from forming.results.pictures.animation import LARGEST, animation

    from ...cosim.run_fields import fields_of

    found = fields_of(run.folder)
    try:
        curve = run.force_curve() if len(found) == 1 else None
    except InputError:
        curve = None
    force = None if curve is None else (curve.stroke, curve.force)
    return "\n".join(
        f"<h3>{escape(name)}</h3>\n{animation(history, force=force, largest=LARGEST // len(found))}"
        for name, history in found.items()
    )


def _manifest(run: Run) -> str:
    manifest = run.manifest
    parts = table(
        ["component", "FMU", "model", "SHA-256", "time"],
        [
            (name, c["fmu"], c["model"], c["sha256"][:16], f"{manifest['timing_s'].get(name, 0.0):.2f} s")
            for name, c in manifest["components"].items()
        ],
        numeric=(4,),
    )
    told = ("mode", "steps", "communication_step", "stop_time", "written", "platform")
    facts = [(k, manifest[k]) for k in told]
    facts += sorted(manifest["versions"].items())
    log = (run.folder / "log.txt").read_text(encoding="utf-8") if (run.folder / "log.txt").is_file() else ""
    return (
        parts
        + table(["what", "value"], facts, narrow=True)
        + f"<details><summary>Log</summary><pre>{escape(log)}</pre></details>"
    )
