"""Model and effects fitted together: parameters with intervals."""
