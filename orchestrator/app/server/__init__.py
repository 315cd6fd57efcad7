"""The server: it listens, guards and builds the application."""
