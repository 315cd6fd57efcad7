"""Every command on damaged files and hostile outputs, thousands of times: ``python -m tests.fuzz --tries 3000 --seed 1 -o report.md``."""
