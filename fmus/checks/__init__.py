"""`check`: an FMU looked at from outside, then tried in a process of its own."""
