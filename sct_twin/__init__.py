"""sct_twin."""
