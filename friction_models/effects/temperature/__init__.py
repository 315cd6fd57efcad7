"""Effects of the contact temperature, also through pressure or flash heating. They see `base`, `parameters` and `expressions`."""
