"""Attribution of a deviation between measured and simulated forces to its likely causes."""
