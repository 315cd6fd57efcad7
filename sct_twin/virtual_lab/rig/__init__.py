"""The virtual rig: sensors, motion, data logger, specimen."""

from friction_models.common.imports.extras import need

need("numba", "solvers", "the virtual laboratory")
