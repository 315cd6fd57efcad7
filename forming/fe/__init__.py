"""The axisymmetric thermo-mechanical kernel: large plastic strains, frictional contact, remeshing.

`simulation.py` decides when a run is remeshed, `remesh.py` does it.
"""

from friction_models.common.imports.extras import need

need("numba", "solvers", "the forming solver")
