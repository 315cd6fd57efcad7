"""The axisymmetric thermo-mechanical kernel: large plastic strains, frictional contact, remeshing."""
