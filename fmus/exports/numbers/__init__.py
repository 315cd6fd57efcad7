"""Hosts that take numbers: tables and fitted coefficients, with the deviation that remains. They see the shared parts of the exports."""
