"""Effects of contact pressure and surface expansion: real contact area, thinning film. They see `base` and `expressions`."""
