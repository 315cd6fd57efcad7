"""The forming-error study: how far each friction model is from the press."""
