"""The form of the page Forming, made from the parameters that each process declares."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

from nicegui import ui

from friction_models.common import InputError
from friction_models.common.markup import table

from ..project import is_name
from .compare import own_models
from .elements import action, choice, fold, number_field, say, text_field, words
from .forming_state import LEVEL, FormState
from .view import View

if TYPE_CHECKING:
    from forming.processes.parameters import Parameter


async def ask(view: View, form: FormState) -> None:
    """Show the form; it is made anew for another process, while other changes only change the command line."""

    @ui.refreshable
    def fields() -> None:
        try:
            known = form.declared()
        except InputError:
            # A value that the process refuses: the button says so, the fields stay as they are declared.
            known = FormState(form.process).declared()
        _fields(view, form, known, changed)

    @ui.refreshable
    def button() -> None:
        try:
            command = form.command()
        except InputError as error:
            say(str(error), "problem")
            return
        action(view, command, "Run them", first=True)

    def changed(**values: Any) -> None:
        for name, value in values.items():
            setattr(form, name, value)
        view.project.keep("forming", asdict(form))
        button.refresh()

    def another(process: str) -> None:
        changed(process=process, values={}, levels={}, stroke=None, press="")
        fields.refresh()

    def curve(path: str) -> None:
        changed(press=path, **(curves[path].filled_in if path else {}))
        fields.refresh()

    curves = await asyncio.to_thread(_curves, view)
    form.press = form.press if form.press in curves else ""
    with ui.element("div").classes("choices"):
        choice("Process", processes(), form.process, another)
        if curves:
            options = {"": "none", **{path: found.label for path, found in curves.items()}}
            choice("Over a press curve", options, form.press, curve)
    fields()
    own = own_models(view.project)
    with ui.element("div").classes("form"):
        kept = [m for m in form.models if m in own]
        form.models = kept
        if own:
            names = {m: m.removeprefix("models/").removeprefix("fmus/") for m in own}
            models = choice("Friction models", names, kept, lambda v: changed(models=list(v)), multiple=True)
            models.props("use-chips").classes("names")
        text_field("Constant mu", form.constants, lambda v: changed(constants=v), "several by commas")
        note = f"without a name: {form.process}"
        text_field("Name of the results", form.name, lambda v: changed(name=v), note)
    ui.checkbox(
        "State how far the loads may be off (each model runs once more with smaller elements)",
        value=form.local_errors,
        on_change=lambda e: changed(local_errors=bool(e.value)),
    )
    button()


def processes() -> dict[str, str]:
    """Return the names of the forming processes; loads the solver, which takes a second or two the first time."""
    from forming.processes.names import PROCESSES

    return {name: kind.name for name, kind in PROCESSES.items()}


def _fields(view: View, form: FormState, known: dict[str, Parameter], changed: Callable[..., None]) -> None:
    """Show a field for each parameter: those of the shape first, what has a good default folded away."""
    from forming.materials.files import shipped

    def shape(p: Parameter) -> bool:
        return p.kind == "number" and p.unit in {"mm", "degrees"} and p.default is not None and p.name != "mesh_size"  # fmt: skip

    def one(p: Parameter) -> None:
        label = p.name if p.name[1:2] == "_" else p.name.replace("_", " ")
        label = f"{label} [{p.unit}]" if p.unit else label
        value = form.values.get(p.name, p.default)
        if p.kind == "switch":
            ui.checkbox(label, value=bool(value), on_change=lambda e: typed(p, bool(e.value)))
        elif p.kind == "material":
            names = shipped()
            own = str(value or "16MnCr5")
            choice(label, names if own in names else [*names, own], own, partial(typed, p))
        else:
            number = None if isinstance(value, str) else value
            precision = 0 if p.kind == "count" else None
            number_field(
                label, number, partial(typed, p), _hint(p), min=p.low, max=p.high, precision=precision
            )

    def typed(p: Parameter, value: Any) -> None:
        values = dict(form.values)
        if value is None or value == p.default:
            values.pop(p.name, None)
        else:
            values[p.name] = int(value) if p.kind == "count" else value
        changed(values=values)

    def level(name: str, value: str) -> None:
        changed(levels={**form.levels, name: value})

    rest = [p for p in known.values() if not shape(p) and p.name not in (*LEVEL, "material")]
    with ui.element("div").classes("form"):
        for p in known.values():
            if shape(p):
                one(p)
        one(known["material"])
        for name, words_ in zip(LEVEL, ("Punch speeds", "Tool temperatures"), strict=True):
            p = known[name]
            value = form.levels.get(name, f"{p.default:g}")
            note = f"{p.low:g} to {p.high:g}, several by commas"
            text_field(f"{words_} [{p.unit}]", value, partial(level, name), note)
        note = "20 mm without one, or what it allows"
        number_field("stroke [mm]", form.stroke, lambda v: changed(stroke=v), note, min=0.1)

    with fold(view, "Tools, heat and mesh"), ui.element("div").classes("form"):
        for p in rest:
            one(p)
    with fold(view, "What the parameters mean"):
        rows = [
            (p.name, p.unit or "-", _allowed(p), "-" if p.default is None else p.default, p.meaning)
            for p in known.values()
        ]
        words(table(["parameter", "unit", "allowed", "default", "meaning"], rows))


def _allowed(p: Parameter) -> str:
    return "-" if p.low is None or p.high is None else f"{p.low:.4g} to {p.high:.4g}"


def _hint(p: Parameter) -> str:
    return _allowed(p) if p.default is not None else f"{_allowed(p)}, or none"


@dataclass(frozen=True)
class _Curve:
    """A press level: what it is called, and what it fills into the form."""

    label: str
    filled_in: dict[str, Any]


def _curves(view: View) -> dict[str, _Curve]:
    """Return the levels of all folders of press curves by the path of their file; a folder that cannot be read is left out."""
    from forming.press import PressCurves

    from ...comparison.level_runs import FormingLevel
    from ...cosim.ready_made import STEP, STROKE

    found: dict[str, _Curve] = {}
    for folder in view.project.press_folders():
        try:
            press = PressCurves.read(folder)
            levels = [(p, FormingLevel.of(p, press.info, STROKE, STEP)) for p in press.levels]
        except InputError:
            continue
        for recorded, level in levels:
            path = f"{view.project.relative(folder)}/{recorded.file}"
            if not is_name(recorded.file):
                continue
            label = f"{folder.name}: {level.process}, {level.speed:g} mm/s, {level.T_tool:g} degC, {recorded.lubricant}"
            filled_in = {
                "process": level.process,
                "stroke": level.stroke,
                "levels": {n: f"{level.numbers[n]:g}" for n in LEVEL},
                "values": {n: v for n, v in level.numbers.items() if n not in LEVEL},
                "name": f"{folder.name}-{PurePosixPath(recorded.file).stem}",
            }
            found[path] = _Curve(label, filled_in)
    return found


def first_form(view: View) -> FormState:
    own = own_models(view.project)
    return FormState(models=[m for m in own if m.startswith("models/")][-2:])
