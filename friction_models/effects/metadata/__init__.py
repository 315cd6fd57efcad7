"""Effects of columns of the test table, constant within a test. They see `base`, `parameters`, `expressions`, `loads` and `common`."""
