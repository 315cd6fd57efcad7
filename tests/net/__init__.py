"""A net to move code over: what a fixed set of commands writes, before and after; not collected by pytest."""
