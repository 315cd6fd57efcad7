"""The sets of forms by name, as results are kept.

The diagnosis was developed on the first set, then on both; the third was written without knowledge of the diagnosis and
is only counted.
"""

from __future__ import annotations

from collections.abc import Mapping

from .forms import FIRST, SECOND, Forms
from .forms_third import THIRD

SETS: Mapping[str, Forms] = {"first": FIRST, "second": SECOND, "third": THIRD}
