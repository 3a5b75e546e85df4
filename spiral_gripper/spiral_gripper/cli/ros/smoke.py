# SPDX-License-Identifier: Apache-2.0
"""The command ``smoke``: one simulated grasp of the node, as a test of the installation."""

from __future__ import annotations

import click

from spiral_gripper.cli.ros.side import load_ros_side
from spiral_gripper.cli.ros.simulate import DEFAULT_GRIPPER, FAULTS
from spiral_gripper.cli.types import output_options


@click.command()
@click.argument("gripper", metavar="[GRIPPER]", default=DEFAULT_GRIPPER)
@click.option(
    "--fault",
    type=click.Choice(FAULTS),
    default="none",
    help="Fault of the simulated regulator, to see that the test reports it.",
)
@output_options
def smoke(gripper: str, fault: str, as_json: bool) -> int:
    """Start node and simulator, wrap and release an object, and compare with what is expected.

    GRIPPER is the name of a shipped gripper or the path of a description file. The object's radius
    is the middle of the gripper's range. All nodes run on this machine, in a new namespace.

    The exit code is 0 if everything was as expected and 1 if not.
    """
    from spiral_gripper.files.description import load_gripper

    load_gripper(gripper)  # a bad description is refused before anything is started
    run = load_ros_side("smoke.run").smoke
    from spiral_gripper.doctor.report import as_document, has_problem, print_answer, print_verdict

    if as_json:
        import json

        result = run(gripper, fault, lambda line: None)
        document = {**as_document(result.answers), "log": list(result.log)}
        click.echo(json.dumps(document, indent=2, ensure_ascii=False))
    else:
        from rich.console import Console

        console = Console(highlight=False)
        result = run(gripper, fault, click.echo)
        console.print()
        for answer in result.answers:
            print_answer(answer, console)
        console.print()
        print_verdict(result.answers, console)
        if has_problem(result.answers):
            click.echo("\n".join(["", "last lines of node and simulator:", *result.log]))
    return 1 if has_problem(result.answers) else 0
