"""Which cause a deviation between measured and simulated forces points to."""
