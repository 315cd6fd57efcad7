"""Chart of a comparison: the error of every model in every test."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from friction_models.common.markup import escape

from ..parts.chart import Chart
from ..parts.theme import looks

#: Most tests that are drawn.
MOST_TESTS = 40


def per_test_chart(per_test: pd.DataFrame, names: Sequence[str]) -> Chart:
    """Return the RMSE of each model in each test, the worst tests of the first model first.

    `per_test` has one row a test and one column a model, in the order in which the models were given; `names`: best first.
    """
    shown = per_test.sort_values(names[0], ascending=False).head(MOST_TESTS)
    chart = Chart()
    # In the order in which they were given, as in the other pictures of the page: a model keeps its colour.
    styles = looks(per_test.columns)
    ids = [escape(i) for i in shown.index]
    for name in names:
        dots = {"size": 8, "color": styles[name]["color"], "opacity": 0.8}
        said = "%{x}: %{y:.4f}<extra>%{fullData.name}</extra>"
        chart.scatter(0, ids, shown[name], escape(name), said, mode="markers", marker=dots)
    chart.dress(360, y="RMSE of mu", from_zero=True)
    chart.figure.update_xaxes(tickangle=-60, type="category")
    return chart
