"""The page Measurements: data sets, and the way from raw files to them."""
