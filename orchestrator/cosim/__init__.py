"""Co-simulation of FMUs: systems, the master that runs them, run folders, SSP archives."""
