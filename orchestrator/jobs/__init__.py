"""Graphs of jobs: run in parallel, results kept under the hash of what decides them, resumed after a stop."""
