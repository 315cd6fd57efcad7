"""The report of a single run: force over stroke, the loads in the contact, timing, manifest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import LOADS, MU

from ..cosim.run_folders import Run
from .parts.markup import escape, table
from .parts.page import Page, figure
from .parts.theme import AFTER, AFTER_BAND, BEFORE, dress


def run_page(folder: Path) -> str:
    """Return the HTML of a run folder."""
    run = Run.load(folder, stopped=True)
    manifest = run.manifest
    largest = _largest_force(run)
    page = Page(
        title=f"{run.name}: largest force {largest:.1f} kN" if largest is not None else run.name,
        kicker="tribofmu run",
        lead=f"{manifest['steps']} steps of {manifest['communication_step']:g} s in the mode <code>{escape(manifest['mode'])}</code>, "
        f"{manifest['timing_s']['total']:.1f} s of computing."
        + ("" if run.complete else f" <strong>Stopped: {escape(run.message)}.</strong>"),
        synthetic=run.synthetic,
    )
    if largest is not None:
        page.add("force", "Force over stroke", _force(run))
    fields = _fields(run)
    if fields:
        page.add("fields", "Fields", fields)
    loads = _contact(run)
    if loads:
        page.add("contact", "Loads in the contact", loads)
    page.add("manifest", "Manifest", _manifest(run))
    return page.render(f"tribofmu {escape(manifest['versions']['tribofmu'])}")


def _largest_force(run: Run) -> float | None:
    if not any(label.endswith(".force") for label in run.values):
        return None
    return float(run.force_curve().force.max())


def _force(run: Run) -> str:
    import plotly.graph_objects as go

    curve = run.force_curve()
    chart = go.Figure()
    chart.add_scatter(
        x=curve.stroke, y=curve.force, line={"color": AFTER, "width": 2.4},
        hovertemplate="stroke %{x:.2f} mm<br>force %{y:.1f} kN<extra></extra>",
    )  # fmt: skip
    dress(chart, 380, legend=False)
    chart.update_xaxes(title_text="stroke [mm]")
    chart.update_yaxes(title_text="punch force [kN]", rangemode="tozero")
    return figure("force", chart, "Punch force over stroke, unfiltered.", "Force over stroke.")


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
    from plotly.subplots import make_subplots

    component = next((label.rpartition(".")[0] for label in run.values if label.endswith(".sigma_n")), None)
    if component is None:
        return ""
    columns = {label: v if v.ndim == 2 else v[:, None] for label, v in run.values.items()}
    active = columns.get(f"{component}.active")
    mask = columns[f"{component}.sigma_n"] > 0.0 if active is None else active > 0.5
    mu = next((v for label, v in columns.items() if label.endswith(".mu") and v.shape == mask.shape), None)
    shown: list[tuple[Any, Any]] = [(q, columns.get(f"{component}.{q.name}")) for q in LOADS] + [(MU, mu)]
    shown = [(q, v) for q, v in shown if v is not None]
    titles = [f"{q.name}" + (f" [{q.unit}]" if q.unit != "1" else "") for q, _ in shown]
    chart = make_subplots(rows=2, cols=3, subplot_titles=titles, shared_xaxes=True, vertical_spacing=0.13)
    rows = np.flatnonzero(mask.any(axis=1))
    if not len(rows):
        return ""
    for number, (quantity, values) in enumerate(shown):
        place = {"row": number // 3 + 1, "col": number % 3 + 1}
        quantiles = np.array([np.quantile(values[k, mask[k]], [0.05, 0.5, 0.95]) for k in rows])
        time = run.time[rows]
        chart.add_scatter(
            x=np.concatenate([time, time[::-1]]), y=np.concatenate([quantiles[:, 2], quantiles[::-1, 0]]),
            fill="toself", fillcolor=AFTER_BAND, line={"width": 0}, mode="lines", hoverinfo="skip", **place,
        )  # fmt: skip
        chart.add_scatter(
            x=time, y=quantiles[:, 1], line={"color": AFTER if quantity is not MU else BEFORE, "width": 2},
            hovertemplate=f"{quantity.name} %{{y:.4g}} at %{{x:.2f}} s<extra></extra>", **place,
        )  # fmt: skip
    dress(chart, 520, legend=False)
    chart.update_xaxes(title_text="time [s]", row=2)
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
    facts = [
        (k, manifest[k]) for k in ("mode", "steps", "communication_step", "stop_time", "written", "platform")
    ]
    facts += sorted(manifest["versions"].items())
    log = (run.folder / "log.txt").read_text(encoding="utf-8") if (run.folder / "log.txt").is_file() else ""
    return (
        parts
        + table(["what", "value"], facts, narrow=True)
        + f"<details><summary>Log</summary><pre>{escape(log)}</pre></details>"
    )
