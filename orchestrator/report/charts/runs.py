"""Charts of one run: force over stroke, and the loads in the contact."""

from __future__ import annotations

import numpy as np

from friction_models.loads import LOADS, MU
from friction_models.loads.contract import with_unit

from ...cosim.run_folders import Run
from ...force_curves.forces import ForceCurve
from ..parts.chart import Chart
from ..parts.theme import AFTER, AFTER_BAND, BEFORE


def run_force_chart(curve: ForceCurve) -> Chart:
    """Return the punch force over the stroke."""
    chart = Chart(legend=False)
    said = "stroke %{x:.2f} mm<br>force %{y:.1f} kN<extra></extra>"
    chart.scatter(0, curve.stroke, curve.force, hover=said, line={"color": AFTER, "width": 2.4})
    return chart.dress(380, x="stroke [mm]", y="punch force [kN]", from_zero=True)


def run_loads_chart(run: Run) -> Chart | None:
    """Return median and range of mu and of each load over the active points along the run; None without contact."""
    component = next((label.rpartition(".")[0] for label in run.values if label.endswith(".sigma_n")), None)
    if component is None:
        return None
    columns = run.columns()
    active = columns.get(f"{component}.active")
    mask = columns[f"{component}.sigma_n"] > 0.0 if active is None else active > 0.5
    mu = next((v for label, v in columns.items() if label.endswith(".mu") and v.shape == mask.shape), None)
    found = {q.name: columns.get(f"{component}.{q.name}") for q in LOADS} | {MU.name: mu}
    shown = {name: values for name, values in found.items() if values is not None}
    rows = np.flatnonzero(mask.any(axis=1))
    if not len(rows):
        return None
    titles = [with_unit(name) for name in shown]
    chart = Chart(3, 2, legend=False, titles=titles, shared_xaxes=True, vertical_spacing=0.13)
    time = run.time[rows]
    for panel, (name, values) in enumerate(shown.items()):
        low, middle, high = np.array([np.quantile(values[k, mask[k]], [0.05, 0.5, 0.95]) for k in rows]).T
        chart.band(panel, time, low, high, AFTER_BAND)
        said = f"{name} %{{y:.4g}} at %{{x:.2f}} s<extra></extra>"
        line = {"color": BEFORE if name == MU.name else AFTER, "width": 2}
        chart.scatter(panel, time, middle, hover=said, line=line)
        if low.min() == high.max():  # plotly would show one unit to either side of a constant
            chart.figure.update_yaxes(rangemode="tozero", **chart.place(panel))
    return chart.dress(520, x="time [s]")


def run_loads_caption(run: Run) -> str:
    """Return what the lines and bands of `run_loads_chart` are."""
    if all(v.ndim == 1 for label, v in run.values.items() if label.endswith(".sigma_n")):
        return "Loads and coefficient of friction of the contact."
    return " ".join(
        [
            "Median (line) and 5 to 95 % range (band) over the contact points that touch the tool.",
            *run.few_points(),
        ]
    )
