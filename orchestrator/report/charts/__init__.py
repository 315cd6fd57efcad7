"""Charts, one file a subject; colours that charts share stand in `parts/theme.py`, what a chart takes or has alone at the top of its file."""
