"""HTML page of a friction FMU: the model, its range, and its use in a simulator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from friction_models.loads import LOADS, MU

from ..interface.friction_source import FrictionSource
from ..interface.quantities import FrictionInterface, bounds, parameter_arrays
from ..interface.time_constants import fastest_time_constant, hint
from ..native.platforms import PLATFORMS
from .documentation import card_json, cell, html
from .response_curves import legend, response_curves, short

_SYSTEMS = {"linux": "Linux", "windows": "Windows", "darwin": "macOS"}
_MACHINES = {"x86_64": "x86-64", "aarch64": "ARM 64"}
#: Entries of the card that are told elsewhere on the page, or repeat the others.
_TOLD = ("name", "family", "formula", "domain", "errors", "model", "format", "format_version", "states")


def friction_documents(
    source: FrictionSource,
    interface: FrictionInterface,
    files: Mapping[str, bytes],
    target: str = "native",
    fmi: str = "2.0",
) -> dict[str, bytes]:
    """Return the files of documentation/ by their path in the archive; libraries and licence among its `files` are listed."""
    parts = [
        _head(source),
        _curves(source, interface),
        _variables(source, interface, fmi),
        _use(source, interface, target, fmi),
        _errors(source.card),
        _libraries(files, target),
        _licence(source, files),
        _card(source),
    ]
    documents = {"documentation/index.html": html(f"Friction model {source.name}", "".join(parts))}
    if source.card:
        documents["documentation/card.json"] = card_json(source.card)
    return documents


def _section(title: str, *parts: str) -> str:
    return f"<h2>{escape(title)}</h2>{''.join(parts)}" if any(parts) else ""


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], numbers: Sequence[int] = ()) -> str:
    """Return a table of cells that are HTML already; columns of `numbers` are aligned to the right."""

    def row(tag: str, cells: Sequence[str]) -> str:
        kind = [' class="n"' if k in numbers else "" for k in range(len(cells))]
        return "<tr>" + "".join(f"<{tag}{c}>{v}</{tag}>" for c, v in zip(kind, cells, strict=True)) + "</tr>"

    body = "".join(row("td", cells) for cells in rows)
    return f'<div class="scroll"><table><thead>{row("th", head)}</thead><tbody>{body}</tbody></table></div>'


def _head(source: FrictionSource) -> str:
    text = f'<p class="soft">Coefficient of friction from {len(LOADS)} local loads. Family: {escape(source.family)}.'
    if isinstance(told := source.card.get("description"), str):
        text += f" {escape(told)}"
    if source.synthetic:
        text += ' <span class="badge">trained on synthetic data</span>'
    text += "</p>"
    return text + (f"<pre>{escape(source.formula)}</pre>" if source.formula else "")


def _curves(source: FrictionSource, interface: FrictionInterface) -> str:
    if not source.onnx:
        return ""
    try:
        picture = response_curves(source, interface)
    except Exception:  # ONNX Runtime refuses the graph, with errors that are not public: no picture
        return ""
    if not picture:
        return ""
    outside = (
        " The margins lie outside of the trained domain: there the FMU uses the nearest point of the domain."
        if interface.domain
        else " No trained domain is recorded; usual ranges are shown."
    )
    caption = f"<figcaption>{escape(legend(interface))}{outside}</figcaption>"
    return _section("mu over each load", f'<figure><div class="scroll">{picture}</div>{caption}</figure>')


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}" if abs(value) < 1000.0 else short(value)


def _range(lower: float | None, upper: float | None) -> str:
    return "" if lower is None or upper is None else f"{_number(lower)}&nbsp;to&nbsp;{_number(upper)}"


def _variables(source: FrictionSource, interface: FrictionInterface, fmi: str) -> str:
    several = {"2.0": "[1] ...", "3.0": "[n]"}[fmi] if interface.sized else ""
    rows = []

    def add(
        name: str, kind: str, unit: str, meaning: str, start: str = "", domain: str = "", array: bool = True
    ) -> None:
        variable = f"<code>{escape(name)}{several if array else ''}</code>"
        rows.append([variable, kind, escape(unit), start, domain, escape(meaning)])

    for q in LOADS:
        unknown = "not measured, no influence" if q.name in source.absent else "not recorded"
        trained = _range(*interface.domain.get(q.name, (None, None))) or unknown
        add(q.name, "input", q.unit, q.meaning, _number(interface.start(q)), trained)
    add(MU.name, "output", MU.unit, MU.meaning + ", never negative")
    distance = "0 inside the trained domain; outside, how far, in units of the range of the load that is farthest out"
    add("domain_distance", "output", "1", distance)
    for bound, meaning in bounds(interface.interval):
        add(bound, "output", "1", meaning + ", never negative")
    add("in_domain", "output", "", "whether every point in contact is inside the domain", array=False)
    for s in interface.states:
        add(s.name, "memory", s.unit, "memory of the contact point", _number(s.start))
    arrays = parameter_arrays(interface.system)
    for a in arrays:
        own = interface.system[a.first]
        values = [p.start for p in interface.system[a.first : a.first + a.size]]
        name = f"{a.name}[{','.join(map(str, a.shape))}]" if fmi == "3.0" else a.elements()[0] + " ..."
        span = _range(min(values), max(values))
        add(name, "parameter", own.unit, own.description, span, array=False)
    inside = {name for a in arrays for name in a.elements()}
    for p in (p for p in interface.system if p.name not in inside):
        domain = _range(p.lower, p.upper)
        add(p.name, "parameter", p.unit, p.description, _number(p.start), domain, array=False)
    clamp = "whether loads outside the trained domain are moved to its border before mu is evaluated"
    add("clamp_to_domain", "parameter", "", clamp, "true", array=False)
    if fmi == "3.0" and interface.sized:
        points = "number of contact points, the length of the arrays"
        add("n", "structural parameter", "", points, str(interface.nodes), array=False)
    return _section(
        "Variables", _table(("name", "kind", "unit", "start", "trained on", "meaning"), rows, (3,))
    )


def _use(source: FrictionSource, interface: FrictionInterface, target: str, fmi: str) -> str:
    points = [
        "Connect the five loads of a contact point in the units above, read <code>mu</code>. It belongs to the "
        "loads that were set last: no step is needed in between, and a step adds no delay.",
    ]
    if interface.states:
        names = ", ".join(f"<code>{escape(s.name)}</code>" for s in interface.states)
        points.append(
            f"The model remembers ({names}): a step advances the memory of each point by the loads that are set, held "
            "over the step. Give every material point its own instance or array element, and keep it. A point with "
            "<code>sigma_n</code> = 0 is without contact and keeps its memory."
        )
        fastest = fastest_time_constant(source) if target == "native" else None
        if fastest is not None:
            points.append(f"In model exchange the simulator's solver integrates the memory: {hint(fastest)}.")
    if fmi == "3.0" and interface.sized:
        points.append(
            "Arrays have the length <code>n</code>, which is set in configuration mode before initialization; with "
            "<code>n</code> = 1 the FMU is used like a scalar one."
        )
    elif interface.nodes > 1:
        points.append(
            f"The FMU evaluates {interface.nodes} contact points: <code>v_rel[1]</code> to "
            f"<code>v_rel[{interface.nodes}]</code> and so on."
        )
    if interface.domain:
        points.append(
            "Outside the trained domain <code>in_domain</code> becomes false and <code>domain_distance</code> grows. With "
            "<code>clamp_to_domain</code> = true mu is that of the nearest point of the domain; with false the law is "
            "extrapolated, at your own risk."
        )
    if interface.interval is not None:
        points.append(
            f"<code>mu_low</code> and <code>mu_high</code> hold {100.0 * interface.interval:g} % of the measured points of "
            "new tests inside the trained domain. Outside of it they move apart with <code>domain_distance</code>, "
            "but nothing was measured there."
        )
    points.append(
        "Values that are not finite are refused: the call returns an error, and the logged message names the "
        "variable. Instances are independent of each other and may run in threads."
        if target == "native"
        else "Values that are not finite are refused with a logged message. The simulator must find Python with "
        "the packages that the model needs."
    )
    if target == "native":
        both = fmi == "3.0"
        ways = "directional and adjoint derivatives" if both else "directional derivatives"
        points.append(
            f"The FMU state can be saved, set back exactly and serialized; {ways} of mu are analytic, for solvers and "
            "optimizers that ask for them."
        )
    points.append(
        "In a coupled forming simulation evaluate friction first, from the last loads, then make the forming "
        "increment with it: one increment of delay. A master that exchanges everything at once makes it two."
    )
    items = "".join(f"<li>{p}</li>" for p in points)
    return _section("In a simulator", f"<ul>{items}</ul>")


def _errors(card: Mapping[str, object]) -> str:
    errors = card.get("errors")
    if not isinstance(errors, dict) or not errors:
        return ""
    if not all(isinstance(v, dict) for v in errors.values()):
        return _section("Errors", f'<div class="scroll">{cell(errors)}</div>')
    names = list(dict.fromkeys(k for v in errors.values() for k in v))
    rows = [[escape(str(part)), *(_shown(values.get(n)) for n in names)] for part, values in errors.items()]
    head = ["data", *(escape(str(n).replace("_", " ")) for n in names)]
    note = '<p class="soft">Errors of mu; data are split by whole tests.</p>'
    return _section("Errors", _table(head, rows, range(1, len(head))), note)


def _shown(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    return "" if value is None else escape(str(value))


def _libraries(files: Mapping[str, bytes], target: str) -> str:
    rows = []
    for path in sorted(n for n in files if n.startswith("binaries/") and n.count("/") == 2):
        if not path.endswith((".so", ".dll", ".dylib")):
            continue
        meaning = path.split("/")[1]
        platforms = [p for p in PLATFORMS.values() if meaning in {p.name, p.folder("2.0")}]
        if platforms:
            system = _SYSTEMS[platforms[0].name.partition("-")[2]]
            machines = " and ".join(_MACHINES[p.name.partition("-")[0]] for p in platforms)
            meaning = f"{system}, {machines}"
        rows.append([escape(meaning), f"<code>{escape(path)}</code>", f"{len(files[path]) / 1000:.0f} kB"])
    if not rows:
        return ""
    note = (
        "The libraries need nothing but the C library of the system. The C source is in <code>sources/</code>, the "
        "model as ONNX in <code>resources/model.onnx</code>."
        if target == "native"
        else "The libraries start the Python of the simulator."
    )
    return _section("Platforms", _table(("system", "library", "size"), rows, (2,)), f"<p>{note}</p>")


def _licence(source: FrictionSource, files: Mapping[str, bytes]) -> str:
    given = source.card.get("licence") or source.card.get("license")
    text = f"<p>Model: {escape(str(given))}</p>" if given else ""
    found = sorted(n for n in files if n.startswith("documentation/licenses/"))
    links = ", ".join(
        f'<a href="{escape(n.removeprefix("documentation/"))}">{escape(n.rpartition("/")[2])}</a>'
        for n in found
    )
    return _section("Licence", text, f"<p>{links}</p>" if links else "")


def _card(source: FrictionSource) -> str:
    rest = {k: v for k, v in source.card.items() if k not in _TOLD and v not in (None, {}, [], "")}
    if not rest:
        return ""
    whole = '<p>All of it, for programs: <a href="card.json">card.json</a>.</p>'
    tables = "".join(
        f"<details{' open' if not isinstance(v, dict | list) else ''}><summary>{escape(str(k))}</summary>"
        f'<div class="scroll">{cell(v)}</div></details>'
        for k, v in rest.items()
    )
    return _section("Model card", tables, whole)
