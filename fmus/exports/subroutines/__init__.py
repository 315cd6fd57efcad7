"""Hosts that take code: C, Fortran around it, Lua. They see the shared parts of the exports and `native`, not the hosts that take numbers."""
