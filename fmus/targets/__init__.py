"""Packing: what is packed, and the kinds of FMUs that come out."""
