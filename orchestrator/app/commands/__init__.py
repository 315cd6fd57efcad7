"""The command lines behind the buttons. Each can be pasted into a shell in the project folder, and gives the same files."""

from . import fmus, forming, measuring, models
from .command import Command, command_of, effect_names, short

__all__ = ["Command", "command_of", "effect_names", "fmus", "forming", "measuring", "models", "short"]
