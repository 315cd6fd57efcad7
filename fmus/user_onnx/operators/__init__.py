"""Translation of the operators of a foreign graph into those that the generator of C knows."""
