"""Measurements that `make bench` runs; none is asserted as wall time by a test."""
