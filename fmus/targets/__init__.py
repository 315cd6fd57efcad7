"""`pack` and its kinds of FMUs: native, Python, solver process, signals."""
