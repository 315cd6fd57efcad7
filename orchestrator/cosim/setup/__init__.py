"""Set-up of a co-simulation: the description of a system, checked and resolved into connected variables."""
