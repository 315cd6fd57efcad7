"""What every package uses: errors, files, folders, locks, units, HTML of pages; imports no other part of the project.

`processes` holds what starts and limits processes, `imports` what is imported at first use or only where it is installed.
"""

from .errors import InputError, check_readable, given_path, inert, nearest, shown, unknown_name
from .files import atomic_folder, atomic_path, check_file, write_json, write_text
from .folders import check_folder, check_outputs, grown

__all__ = [
    "InputError",
    "atomic_folder",
    "atomic_path",
    "check_file",
    "check_folder",
    "check_outputs",
    "check_readable",
    "given_path",
    "grown",
    "inert",
    "nearest",
    "shown",
    "unknown_name",
    "write_json",
    "write_text",
]
