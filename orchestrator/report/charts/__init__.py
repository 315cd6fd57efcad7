"""Charts, one file a subject; their colours stand in `parts/theme.py`, those of curves side by side in `parts/palette.py`."""
