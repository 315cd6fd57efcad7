"""What no model explains: noise floor, flexible reference, odd tests."""
