"""Imports at first use, and of what may not be installed: lazy names, extras, plug-ins, who draws. They see `errors` and `markup`."""
