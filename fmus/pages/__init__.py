"""What an FMU shows to people: documentation page, response curves, icon, terminal."""
