"""Meshing of axisymmetric regions: elements, outlines, mesher."""
