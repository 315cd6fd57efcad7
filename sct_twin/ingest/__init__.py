"""Measurement files of any laboratory become a campaign of records."""
