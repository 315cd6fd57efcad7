"""What every page is built of: page frame, markup, theme, palette."""
