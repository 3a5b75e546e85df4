# SPDX-License-Identifier: Apache-2.0
"""A group of commands: the same behavior in every version of click, and advice on wrong names."""

from __future__ import annotations

import sys
from difflib import get_close_matches

import click


class NoCommandError(click.ClickException):
    """No command was given; its message is the help."""


class Group(click.Group):
    """A group that refuses to be called without a command (click 8.1 called that a success)."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Return the arguments that remain; raise NoCommandError if there are none."""
        if not args:
            raise NoCommandError(ctx.get_help())
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            path = ctx.command_path
            raise click.UsageError(
                f"{error.option_name} is an option of a command; write the command before it; "
                f"the commands of {path} are {', '.join(self.list_commands(ctx))}"
            ) from None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that the arguments name; say which one is meant if there is none."""
        if self.get_command(ctx, args[0]) is None:
            raise click.UsageError(f"there is no command {args[0]!r}; {self._advice(ctx, args)}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands, the first sentence of each in full."""
        commands = {name: self.get_command(ctx, name) for name in self.list_commands(ctx)}
        with formatter.section("Commands"):
            formatter.write_dl(
                [(n, c.get_short_help_str(limit=sys.maxsize)) for n, c in commands.items() if c]
            )

    def _advice(self, ctx: click.Context, args: list[str]) -> str:
        """Return what was probably meant."""
        path, names = ctx.command_path, self.list_commands(ctx)
        rest = " ".join(f'"{part}"' if " " in part else part for part in args[1:])
        near = get_close_matches(args[0].lower(), names, n=1)
        if near:
            return f"did you mean {path} {near[0]}?"
        for name in names:
            group = self.get_command(ctx, name)
            if isinstance(group, click.Group) and args[0] in group.list_commands(ctx):
                return f"did you mean {path} {name} {args[0]} {rest}".rstrip() + "?"
        listed = f"the commands of {path} are {', '.join(names)}"
        likely = next((name for name in ("wrap", "pressure", "show") if name in names), "")
        from spiral_gripper.files.catalog import available_grippers

        if likely and (args[0].endswith((".yaml", ".yml")) or args[0] in available_grippers()):
            example = f"{path} {likely} {args[0]} {rest}".rstrip()
            return f"a command comes before the gripper, as in {example}; {listed}"
        return listed
