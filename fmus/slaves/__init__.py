"""Python FMU slaves: ONNX Runtime for a friction model, the forming solver, the tribometer twin."""
