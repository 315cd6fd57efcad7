"""What an FMU of ours shows: the packed model, its variables, its model description for FMI 2.0 and FMI 3.0."""
