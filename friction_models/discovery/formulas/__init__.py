"""Empirical terms for structure that no effect of the catalogue explains: which there are, and which predict unseen tests."""
