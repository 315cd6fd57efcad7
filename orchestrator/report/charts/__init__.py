"""Charts, one file a subject; colours of all pages stand in `parts/theme.py`, which of them a chart takes at the top of its file."""
