"""Figures of measurements and residuals that only the workbench draws."""
