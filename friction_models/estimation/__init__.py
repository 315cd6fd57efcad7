"""Estimation of effects from measurements: binning, noise floor, candidates, scan, significance, joint fit."""
