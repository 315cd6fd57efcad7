"""Native friction FMUs: C99 from the ONNX graph, wrapped as FMI, compiled for the wanted platforms.

`front*` is the C front of solver FMUs, behind which the solver runs in a process of its own.
"""
