"""Processes and their share of the machine: pools, safe child processes, one thread for linear algebra, progress. They see `errors` alone."""
