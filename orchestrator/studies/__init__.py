"""The studies of the paper as campaigns of jobs: a folder a study, and beside them the jobs that several share."""
