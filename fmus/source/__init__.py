"""Models on their way into an FMU: how they are read, and the results that the FMU must repeat."""
