"""Tests of tribofmu."""
