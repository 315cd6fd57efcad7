"""Co-simulation: system description, wiring, master, run folders, SSP systems."""
