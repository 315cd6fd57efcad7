"""Tools: elastic dies and punches, ejection tools, geometry of the punch."""
