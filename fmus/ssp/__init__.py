"""SSP 1.0 archives: systems of FMUs, written and read."""
