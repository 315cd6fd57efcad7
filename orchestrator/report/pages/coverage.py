"""The report of a coverage map: what was tested, what the process asks for, which tests would cover it."""

from __future__ import annotations

from friction_models.common.markup import bullets, escape, paragraph, table
from friction_models.loads.contract import with_unit

from ...coverage.tested_loads import Coverage
from ..charts.coverage import pairs_chart, shares_chart
from ..parts.page import Page


def coverage_page(coverage: Coverage, label: str) -> str:
    """Return the HTML of a coverage map; `label` names the process."""
    page = Page(
        title=f"Coverage of {label}",
        kicker="tribofmu coverage",
        lead=escape(coverage.sentence),
        synthetic=coverage.synthetic,
    )
    rows = [
        (
            with_unit(s.names[0]), "{:.4g} to {:.4g}".format(*s.tested[0]), "{:.4g} to {:.4g}".format(*s.asked[0]),
            f"{100 * s.area:.1f} %", f"{100 * s.work:.1f} %",
        )
        for s in coverage.loads
    ]  # fmt: skip
    page.plot(
        "loads",
        "Load by load",
        shares_chart(coverage),
        "Share of the process outside the tested loads.",
        "Bars for each load.",
        table(["load", "tested", "process", "area outside", "work outside"], rows, numeric=(1, 2, 3, 4)),
    )
    if len(coverage.loads) > 1:
        page.plot(
            "pairs",
            "Pairs of loads",
            pairs_chart(coverage),
            "Where the friction work of the process is done (colour), and the hull of all tested points (line): "
            "what lies outside the line, the model extrapolates.",
            "Maps of friction work over each pair of loads with the outline of the tested region.",
        )
    if coverage.proposals:
        keys = ("sigma_set", "psi_set", "v_set", "T_tool", "sd_set")
        proposed = [
            (
                *(f"{p['setpoints'][k]:g}" for k in keys),
                ", ".join(f"{' with '.join(c['loads'])} {100 * c['share']:.1f} %" for c in p["covers"]),
            )
            for p in coverage.proposals
        ]
        page.add(
            "tests",
            "Tests that would cover more",
            table(
                ["pressure [MPa]", "expansion", "speed [mm/s]", "tool [degC]", "distance [mm]", "adds"],
                proposed,
                numeric=range(1, 5),
                caption="What each test adds: mean of its shares of contact area and friction work.",
            ),
        )
    if coverage.beyond_rig:
        page.add("beyond", "Beyond every test of the rig", bullets(coverage.beyond_rig))
    page.add("notes", "Notes", paragraph(f"Process: {coverage.history.source}"), bullets(coverage.notes))
    return page.render()
