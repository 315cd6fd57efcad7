"""Heat of sliding: temperatures of specimen and plate, and the check of them. It sees no other part of the twin."""
