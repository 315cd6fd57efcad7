"""forming."""
