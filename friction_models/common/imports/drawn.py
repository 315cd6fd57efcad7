"""Answers that draw themselves: `plot()`, and how they look in a notebook. Who draws is found by entry point."""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import TYPE_CHECKING

from ..errors import InputError
from ..markup import escape
from .extras import need

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: A function ``(answer, what) -> plotly figure``; packages with pictures enter theirs.
ENTRY_POINT_GROUP = "tribofmu.pictures"


class Drawn:
    """Gives a class `plot`, and a notebook its text.

    A class has `report`, or a `sentence`, or neither: then its `repr` stands in the notebook.
    """

    def plot(self, what: str = "") -> go.Figure:
        """Return a picture as a plotly figure; the pages show the same ones.

        Parameters
        ----------
        what : str, optional
            Name of the picture, by default the first one; a wrong name is answered with all of them.

        Raises
        ------
        InputError
            No such picture, or there is nothing to draw in it.
        """
        makers = [*entry_points(group=ENTRY_POINT_GROUP)]
        if not makers:
            raise InputError(
                f"plot: no package that draws is installed (entry point {ENTRY_POINT_GROUP}); allowed: install tribofmu as a whole"
            )
        need("plotly", "reports", "a picture")
        figure: go.Figure = makers[0].load()(self, what)
        return figure

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        report = getattr(self, "report", None)
        said = report() if callable(report) else getattr(self, "sentence", None) or repr(self)
        return f'<pre style="white-space: pre-wrap">{escape(str(said))}</pre>'
