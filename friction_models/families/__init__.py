"""The families of friction models, one file each."""
