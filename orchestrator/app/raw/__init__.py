"""Sets of measurement files as they were brought, and their maps."""
