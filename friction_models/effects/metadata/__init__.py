"""Effects of columns of the test table, constant within a test. They see `base`, `expressions`, `loads` and `common`."""
