"""From raw channels to the sliding phase: filters, zeros, motion, phases, uncertainty."""

from friction_models.common.imports.extras import need

need("numba", "solvers", "reading records of compression tests")
