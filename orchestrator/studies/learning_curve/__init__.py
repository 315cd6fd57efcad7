"""The learning-curve study: how many tests a friction model needs."""
