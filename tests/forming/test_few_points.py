"""A run in which few markers touch a tool says that means over them are not to be trusted; others do not."""

from __future__ import annotations

import numpy as np
import pytest

from forming import BackwardCupExtrusion, ForwardRodExtrusion
from forming.results.few_points import FEWEST, few_points
from forming.results.pictures.page import report_page


@pytest.mark.parametrize(("kind", "few"), [(ForwardRodExtrusion, True), (BackwardCupExtrusion, False)])
def test_the_page_of_a_short_run_says_when_few_points_touch(kind, few):
    """At 1 mm a billet of 80 markers touches the shoulder of the die with 6 to 9, but container and plate of a cup with 70."""
    result = kind(mesh_size=0.8).run(0.08, 1.0)
    counted = result.contact.active.sum(axis=1).mean()
    assert (counted < FEWEST) == few
    assert (f"Only {counted:.2g} of 80 points touch a tool" in report_page(result)) == few


def test_steps_without_contact_do_not_count():
    active = np.zeros((10, 40), dtype=bool)
    assert few_points(active) == ""
    active[5:, : FEWEST + 2] = True
    assert few_points(active) == ""
    active[5:, FEWEST - 1 :] = False
    assert few_points(active).startswith("Only 9 of 40 points")
