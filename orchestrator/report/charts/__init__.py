"""Charts, one file a subject."""
