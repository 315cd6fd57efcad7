"""A project folder, its history, and the data sets that were read."""

from .project import FOLDERS, HISTORY, SETTINGS, WORK, Project, is_name, name_of

__all__ = ["FOLDERS", "HISTORY", "SETTINGS", "WORK", "Project", "is_name", "name_of"]
