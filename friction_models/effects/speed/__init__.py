"""Effects of the sliding speed: mixed lubrication, Stribeck curves, the viscous film. They see `base`, `parameters` and `expressions`."""
