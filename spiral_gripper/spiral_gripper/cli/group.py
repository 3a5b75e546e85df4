"""A group of commands that is alike in every version of click."""

from __future__ import annotations

import click


class NoCommandError(click.ClickException):
    """No command was given; its message is the help."""


class Group(click.Group):
    """A group that refuses to be called without a command (click 8.1 called that a success)."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Return the arguments that remain; raise NoCommandError if there are none."""
        if not args:
            raise NoCommandError(ctx.get_help())
        return super().parse_args(ctx, args)
