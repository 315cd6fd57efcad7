"""The report of a single run: force over stroke, the loads in the contact, timing, manifest."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from friction_models.common import InputError
from friction_models.common.markup import escape, table
from friction_models.loads import LOADS, MU
from friction_models.loads.contract import with_unit

from ..cosim.run_folders import Run
from ..force_curves.forces import ForceCurve
from .parts.chart import Chart, figure
from .parts.page import Page
from .parts.theme import AFTER, AFTER_BAND, BEFORE


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
    if forms:
        title, caption = "Force over stroke", "Punch force over stroke, unfiltered."
        page.plot("force", title, _force(run.force_curve()), caption, "Force over stroke.")
    if fields := _fields(run):
        page.add("fields", "Fields", fields)
    if loads := _contact(run):
        page.add("contact", "Loads in the contact", loads)
    page.add("manifest", "Manifest", _manifest(run))
    return page.render(f"tribofmu {escape(manifest['versions']['tribofmu'])}")


def _force(curve: ForceCurve) -> Chart:
    chart = Chart(legend=False)
    said = "stroke %{x:.2f} mm<br>force %{y:.1f} kN<extra></extra>"
    chart.scatter(0, curve.stroke, curve.force, hover=said, line={"color": AFTER, "width": 2.4})
    return chart.dress(380, x="stroke [mm]", y="punch force [kN]", from_zero=True)


def _fields(run: Run) -> str:
    """Return the fields that `simulate --fields` saved, as animations of 2.5 MB in all."""
    if not (run.folder / "fields").is_dir():
        return ""
    from forming.results.animation import LARGEST, animation

    from ..cosim.run_fields import fields_of

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


def _contact(run: Run) -> str:
    """Return median and range of mu and of each load over the active points along the run."""
    component = next((label.rpartition(".")[0] for label in run.values if label.endswith(".sigma_n")), None)
    if component is None:
        return ""
    columns = {label: v if v.ndim == 2 else v[:, None] for label, v in run.values.items()}
    active = columns.get(f"{component}.active")
    mask = columns[f"{component}.sigma_n"] > 0.0 if active is None else active > 0.5
    mu = next((v for label, v in columns.items() if label.endswith(".mu") and v.shape == mask.shape), None)
    found = {q.name: columns.get(f"{component}.{q.name}") for q in LOADS} | {MU.name: mu}
    shown = {name: values for name, values in found.items() if values is not None}
    rows = np.flatnonzero(mask.any(axis=1))
    if not len(rows):
        return ""
    titles = [with_unit(name) for name in shown]
    chart = Chart(3, 2, legend=False, titles=titles, shared_xaxes=True, vertical_spacing=0.13)
    time = run.time[rows]
    for panel, (name, values) in enumerate(shown.items()):
        low, middle, high = np.array([np.quantile(values[k, mask[k]], [0.05, 0.5, 0.95]) for k in rows]).T
        chart.band(panel, time, low, high, AFTER_BAND)
        said = f"{name} %{{y:.4g}} at %{{x:.2f}} s<extra></extra>"
        line = {"color": BEFORE if name == MU.name else AFTER, "width": 2}
        chart.scatter(panel, time, middle, hover=said, line=line)
    chart.dress(520, x="time [s]")
    caption = "Median (line) and 5 to 95 % range (band) over the contact points that touch the tool."
    if mask.shape[1] == 1:
        caption = "Loads and coefficient of friction of the contact."
    return figure("contact", chart, caption, "Loads and friction in the contact over time.")


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
