"""What the command line prints for programs."""

from __future__ import annotations

import json

import click

from spiral_gripper.design_document import plain


def print_json(value: object) -> None:
    """Print a value as JSON, in SI units; what does not exist is null."""
    click.echo(json.dumps(plain(value), indent=2, allow_nan=False, ensure_ascii=False))
