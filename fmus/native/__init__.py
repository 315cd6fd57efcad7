"""Native friction FMUs: C99 from the ONNX graph, wrapped as FMI, compiled for the wanted platforms."""
