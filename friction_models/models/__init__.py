"""What every friction model offers: fitting, prediction, intervals, domain, card, saving, export to ONNX."""
