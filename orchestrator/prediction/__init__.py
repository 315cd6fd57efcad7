"""Prediction of sliding compression tests with a friction FMU, before they are run."""
