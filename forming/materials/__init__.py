"""Workpiece materials: flow curves, elasticity, heat data, material files."""
