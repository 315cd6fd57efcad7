"""Prediction intervals of mu: what they are, and how they are calibrated on whole tests that a model has not seen."""
