"""The axisymmetric thermo-mechanical kernel: large plastic strains, frictional contact, remeshing."""

from friction_models.common.imports.extras import need

need("numba", "solvers", "the forming solver")
