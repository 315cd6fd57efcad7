"""Variables and model descriptions of our FMUs, for FMI 2.0 and FMI 3.0."""
