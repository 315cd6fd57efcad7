"""The page of a forming run: force and work, animation of the fields, loads in the contact, ejection, key figures."""

from __future__ import annotations

import numpy as np

from friction_models.common.markup import document, escape, paragraph, table
from friction_models.loads import LOADS
from friction_models.loads.contract import with_unit

from ...fe.mesh.shape import FloatArray
from ..contact_history import ContactHistory
from ..ejection_result import EjectionResult
from ..few_points import few_points
from ..local_errors import summary
from ..record import FormingRecord
from .animation import animation
from .drawing import FONT, INK, SOFT, number, ticks

_STYLE = f"""
body {{ margin: 0; background: #fff; color: {INK}; font: 16px/1.55 {FONT}; }}
main {{ max-width: 1040px; margin: 0 auto; padding: 28px; }}
h1 {{ font-size: 1.75rem; line-height: 1.2; margin: 0 0 6px; }}
h2 {{ font-size: 1.2rem; margin: 2em 0 0.4em; }}
.kicker {{ color: {SOFT}; margin: 0 0 6px; font-size: 0.9rem; }}
.note {{ border-left: 3px solid #e0b93a; background: #fdf8e7; padding: 9px 14px; max-width: 48em; }}
.scroll {{ overflow-x: auto; }}
table {{ border-collapse: collapse; font-size: 0.92rem; }}
th, td {{ padding: 5px 18px 5px 0; text-align: left; border-bottom: 1px solid #e1e6eb; }}
td {{ text-align: right; font-variant-numeric: tabular-nums; }}
.charts {{ display: flex; flex-wrap: wrap; gap: 20px; }}
svg {{ max-width: 100%; height: auto; }}
@media print {{ h2 {{ break-after: avoid; }} svg, table {{ break-inside: avoid; }} }}
"""
_ACCENT, _BAND = "#0a7f79", "#cfe5e3"


def report_page(result: FormingRecord, name: str = "forming") -> str:
    """Return the page as one HTML text without any reference to the network."""
    headline = f"Largest force {result.max_force:.1f} kN over a stroke of {result.stroke[-1]:.2f} mm"
    parts = [f"<main>\n{paragraph(f'tribofmu forming: {name}', 'kicker')}\n<h1>{escape(headline)}</h1>"]
    if result.status != "ok":
        parts.append(paragraph(result.message, "note"))
    parts += [paragraph(text, "note") for text in result.warnings]
    if len(result.fields):
        parts += ["<h2>Fields</h2>", animation(result.fields, force=(result.stroke, result.force))]
    parts += [
        '<h2>Force and work</h2>\n<div class="charts">',
        chart("stroke [mm]", "force [kN]", result.stroke, result.force),
        chart("stroke [mm]", "work [J]", result.stroke, result.work),
        "</div>",
        _contact(result),
        _ejection(result.ejection) if result.ejection is not None else "",
        f"<h2>Key figures</h2>\n{_figures(result)}\n</main>",
    ]
    return document(headline, f"<style>{_STYLE}</style>\n", "\n".join(p for p in parts if p))


def _figures(result: FormingRecord) -> str:
    rows = [
        ("largest force, averaged over 0.5 mm of stroke", f"{result.max_force:.2f} kN"),
        ("largest force as computed", f"{result.force.max():.2f} kN"),
        ("work", f"{result.work[-1]:.1f} J"),
        ("highest friction stress over shear yield stress", f"{result.max_tau_over_k:.3f}"),
        ("share of the contact above 0.6 k", f"{100.0 * result.share_above_0_6k:.2f} %"),
        ("energy balance: (plastic + friction + elastic + contact springs) / external - 1", f"{100.0 * result.energy_balance:+.3f} %"),
        ("change of the unloaded volume", f"{100.0 * result.volume_change:+.4f} %"),
        ("increments, of them failed; remeshings",
         f"{result.increments}, {result.failed_increments}; {result.remeshes}"),
    ]  # fmt: skip
    return table((), rows)


#: What moves in a phase of the ejection.
_MOVES = {"withdraw": "punch withdrawn", "release": "stripper taken back", "eject": "ejector pushes"}


def _ejection(ejection: EjectionResult) -> str:
    """Force over travel of each phase, and where the tools hold the product once the punch is free."""
    charts = []
    for phase in dict.fromkeys(ejection.phase):
        on = ejection.of_phase(phase)
        x = f"{_MOVES[phase]}: travel [mm]"
        charts.append(chart(x, "force [kN]", ejection.travel[on], ejection.force[on]))
    rows = [
        (p.tool, _range(p.r_low, p.r_high), _range(p.z_low, p.z_high), f"{p.pressure:.0f}", f"{p.friction:.2f}")
        for p in ejection.patches
    ]  # fmt: skip
    headings = ["held by", "r [mm]", "z [mm]", "pressure [MPa]", "friction it can carry [kN]"]
    note = "" if ejection.status == "ok" else paragraph(ejection.message, "note")
    heading, tool = ("Ejection", "ejector") if ejection.how == "ejector" else ("Stripping", "punch")
    return (
        f"<h2>{heading}</h2>{note}\n<p>Largest force of the "
        f"{tool} {ejection.max_force:.1f} kN (averaged over 0.5 mm; the curve is as computed); work "
        f'{ejection.total_work:.1f} J. A negative force drives the tool: the workpiece springs back.</p>\n<div class="charts">'
        f"{''.join(charts)}</div>\n{table(headings, rows) if rows else ''}"
    )


def _range(low: float, high: float) -> str:
    return " to ".join(f"{round(v, 2) + 0.0:.2f}" for v in (low, high))  # + 0.0: no minus sign before a zero


def _contact(result: FormingRecord) -> str:
    """Median and 5 to 95 % range of each load, mu and tau/k over the markers in contact."""
    contact = result.contact
    steps = np.flatnonzero(contact.active.any(axis=1))
    if not len(steps):
        return ""
    shown = {with_unit(q.name): contact.loads[:, :, k] for k, q in enumerate(LOADS)}
    shown |= {"mu": contact.mu, "tau/k": contact.tau_over_k}
    charts = []
    for label, values in shown.items():
        low, middle, high = np.array(
            [np.quantile(values[k, contact.active[k]], [0.05, 0.5, 0.95]) for k in steps]
        ).T
        charts.append(chart("stroke [mm]", label, contact.stroke[steps], middle, (low, high)))
    few = few_points(contact.active)
    return (
        "<h2>Loads in the contact</h2>\n<p>Median (line) and 5 to 95 % range (band) over the markers that touch "
        f'a tool.</p>{paragraph(few, "note") if few else ""}\n<div class="charts">{"".join(charts)}</div>{_errors(contact)}'
    )


def _errors(contact: ContactHistory) -> str:
    """How far the loads may be off, where the run has said it."""
    if contact.errors is None:
        return ""
    rows = [
        (
            with_unit(name),
            number(float(f"{middle:.3g}")),
            number(float(f"{usual:.2g}")),
            number(float(f"{high:.2g}")),
        )
        for name, middle, usual, high in summary(contact.loads, contact.active, contact.errors)
    ]
    headings = ["load", "median", "stated error, median", "stated error, 90 % of the markers below"]
    return (
        "\n<p>How far the loads may be off because of the mesh, from one more run with smaller elements; about "
        f"nine of ten markers are closer to a much finer mesh.</p>\n{table(headings, rows)}"
    )


def chart(
    x_label: str,
    y_label: str,
    x: FloatArray,
    y: FloatArray,
    band: tuple[FloatArray, FloatArray] | None = None,
) -> str:
    """Return a small line chart as SVG; `band` is drawn behind the line."""
    width, height, left, right, top, bottom = 318, 222, 56, 12, 26, 40
    every = [y] if band is None else [y, *band]
    low = min(0.0, *(float(v.min()) for v in every))
    high = max(float(v.max()) for v in every)
    high = low + 1.0 if high <= low else high + 0.05 * (high - low)
    first, last = min(0.0, float(x[0])), max(float(x[-1]), 1e-9)

    def place(xs: FloatArray, ys: FloatArray) -> str:
        h = left + (xs - first) / (last - first) * (width - left - right)
        v = height - bottom - (ys - low) / (high - low) * (height - top - bottom)
        return "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(h, v))

    parts = [
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" font-size="12" '
        f'fill="{SOFT}" aria-label="{escape(y_label)} over {escape(x_label)}">'
        f'<text x="{left - 44}" y="14" fill="{INK}" font-weight="600">{escape(y_label)}</text>'
    ]
    for value in ticks(low, high, 4):
        at = float(place(np.array([first]), np.array([value])).split()[1])
        parts.append(
            f'<path d="M{left} {at}H{width - right}" stroke="#e1e6eb"/>'
            f'<text x="{left - 6}" y="{at + 4:.1f}" text-anchor="end">{number(float(f"{value:.6g}"))}</text>'
        )
    for value in ticks(first, last, 5):
        at = float(place(np.array([value]), np.array([low])).split()[0])
        parts.append(
            f'<text x="{at}" y="{height - bottom + 16}" text-anchor="middle">{number(float(f"{value:.6g}"))}</text>'
        )
    parts.append(
        f'<text x="{(left + width - right) / 2}" y="{height - 6}" text-anchor="middle">{escape(x_label)}</text>'
    )
    if band is not None:
        outline = place(np.concatenate([x, x[::-1]]), np.concatenate([band[0], band[1][::-1]]))
        parts.append(f'<path d="M{outline}Z" fill="{_BAND}"/>')
    parts.append(f'<path d="M{place(x, y)}" fill="none" stroke="{_ACCENT}" stroke-width="2"/></svg>')
    return "".join(parts)
