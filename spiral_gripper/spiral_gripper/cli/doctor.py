# SPDX-License-Identifier: Apache-2.0
"""The command ``doctor``: checks of the installation, the gripper files and ROS 2."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from spiral_gripper.cli.types import output_options

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rich.console import Console

    from spiral_gripper.doctor.checks import Answer


@click.command()
@click.argument("gripper", metavar="[GRIPPER]", required=False)
@output_options
def doctor(gripper: str | None, as_json: bool) -> int:
    """Check the installation, the grippers and ROS 2; report what is wrong and how to fix it.

    GRIPPER is the name of a shipped gripper or the path of a description file; without it all
    shipped ones are checked. Kernels that are not compiled yet are compiled. Nothing else is
    changed, and no gripper is commanded.

    The exit code is 0 without problems (warnings are allowed) and 1 with a problem.
    """
    from spiral_gripper.doctor.report import as_document, has_problem

    if as_json:
        import json

        answers = list(_answers(gripper, lambda _: None))
        click.echo(json.dumps(as_document(answers), indent=2, ensure_ascii=False))
    else:
        from rich.console import Console

        answers = _print_answers(gripper, Console(highlight=False))
    return 1 if has_problem(answers) else 0


def _print_answers(gripper: str | None, console: Console) -> list[Answer]:
    """Print answers as they come; return them."""
    from spiral_gripper.doctor.report import print_answer, print_section, print_verdict

    answers: list[Answer] = []
    section = ""
    with console.status("") as status:  # says what is being looked at
        for answer in _answers(gripper, lambda title: status.update(f"{title} ...")):
            if answer.section not in ("", section):
                section = answer.section
                if answers:
                    console.print()
                print_section(section, console)
            print_answer(answer, console)
            answers.append(answer)
    console.print()
    print_verdict(answers, console)
    return answers


def _answers(gripper: str | None, announce: Callable[[str], None]) -> Iterator[Answer]:
    """Yield the answers of all tables."""
    from spiral_gripper.doctor.run import examine, tables

    for table in tables():
        yield from examine(table, gripper, announce)
