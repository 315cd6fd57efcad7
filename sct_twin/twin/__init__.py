"""The digital twin of the test: upsetting, heat of sliding (`heat`), and the loads that follow from them."""

from friction_models.common.imports.extras import need

need("numba", "solvers", "the digital twin")
