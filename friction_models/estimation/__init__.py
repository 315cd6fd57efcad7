"""Estimation of effects from measurements: noise floor, candidates, scan, joint fit, significance."""
