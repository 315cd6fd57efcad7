"""Campaigns of jobs that need each other: done in parallel, kept, resumed."""
