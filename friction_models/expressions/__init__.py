"""Formulas once, two back ends: NumPy and ONNX graphs, with what both need (trees, scaling, parameters)."""
