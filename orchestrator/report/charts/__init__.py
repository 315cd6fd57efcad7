"""Charts, one file a subject; colours of all pages stand in `parts/theme.py`, those of one chart at the top of its file."""
