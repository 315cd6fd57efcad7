"""Records of sliding compression tests: channels, their units, and what a record holds."""
