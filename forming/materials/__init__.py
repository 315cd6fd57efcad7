"""Materials of workpieces and tools: flow curves, elasticity, heat data, material files."""
