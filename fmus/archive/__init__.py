"""Reads and writes FMU and SSP archives. Everything that opens one passes through the checks here."""
