"""Reads models to be packed, and computes the reference results that the FMU must repeat."""
