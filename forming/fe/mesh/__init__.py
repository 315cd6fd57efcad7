"""Meshes of axisymmetric regions: elements, outlines, mesher, transfer between meshes."""
