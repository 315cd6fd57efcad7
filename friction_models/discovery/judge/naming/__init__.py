"""Which names stay: sets of effects, their rivals, and laws that a name only draws, compared on unseen tests."""
