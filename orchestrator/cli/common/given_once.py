"""A command that refuses an option that is given several times, or a flag and its opposite: the last one would win without a word.

A number below 0 in the first place is an argument.
"""

from __future__ import annotations

import re
from collections import Counter

import typer
from typer.core import TyperCommand, TyperOption


class GivenOnce(TyperCommand):
    """Command whose options are given once at most, but those of several values."""

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:  # type: ignore[override]
        """Parse as Typer does. Raises typer.BadParameter: an option is given several times."""
        # No option begins with a digit: what takes the number says what is allowed.
        if args and re.match(r"-\.?\d", args[0]):
            ctx.ignore_unknown_options = True
        for option, times in Counter(self.make_parser(ctx).parse_args(list(args))[2]).items():
            if isinstance(option, TyperOption) and not option.multiple and times > 1:
                raise typer.BadParameter(f"given {times} times; allowed: once", ctx, option)
        return super().parse_args(ctx, args)
