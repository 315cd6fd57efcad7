"""Faults of the measurement that look like an effect: sensors and the twin. They see `base`, `parameters` and `expressions`."""
