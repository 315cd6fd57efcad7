"""Effects of the sliding distance and of what the contact remembers on its way. They see `base`, `parameters` and `expressions`."""
