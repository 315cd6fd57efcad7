"""What else may have made what an answer names, or what it leaves: wrong tests, jumps, factors that nobody recorded, other laws."""
