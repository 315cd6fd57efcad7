"""The answer as data, words and figures."""
