"""What every page is built of: page frame, the class `Chart`, cards, colours."""
