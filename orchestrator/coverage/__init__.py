"""Coverage of the loads of a forming process by tests, and proposals of further tests."""
