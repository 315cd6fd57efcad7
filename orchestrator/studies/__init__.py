"""The studies of the paper, as campaigns of jobs."""
