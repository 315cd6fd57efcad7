"""The search for effects beside a model: candidates, gains, significance, structure that is left."""
