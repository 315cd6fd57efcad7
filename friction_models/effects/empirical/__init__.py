"""Empirical terms: curves of one or two loads that describe tests and have no law behind them. They see `base`, `parameters`, `expressions`, `loads` and `common`."""
