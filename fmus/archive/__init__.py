"""The guarded door into FMU and SSP archives: written byte by byte alike, read without trusting them."""
