# SPDX-License-Identifier: Apache-2.0
"""Commands to a running node: ``plan``, ``grasp``, ``release``, ``status`` and ``watch``."""

from __future__ import annotations

import math
from typing import Any

import click

from spiral_gripper.cli.output import print_json
from spiral_gripper.cli.ros.side import load_ros_side
from spiral_gripper.cli.ros.simulate import namespace_option
from spiral_gripper.cli.types import (
    MASS,
    POSITIVE_LENGTH,
    POSITIVE_NUMBER,
    QuantityType,
    option,
    output_options,
    units_option,
    wanted,
)
from spiral_gripper.cli.workers import progress_bar

SIDE = "tools.commands"


node_option = namespace_option("Namespace of the gripper's node.", default="/")
timeout_option = option(
    "--timeout",
    POSITIVE_NUMBER,
    "Time limit.  [default: the node's grasp.timeout]",
    metavar="SECONDS",
)
overpressure_option = option(
    "--overpressure",
    QuantityType("PRESSURE", least=0.0),
    "Pressure to add to the pressure of the wrap.  [default: what the node recommends]",
)


def _show(answer: Any) -> int:  # noqa: ANN401
    """Print an answer; return 0 if it is good, else 1."""
    if wanted("json"):
        print_json(answer.document)
    else:
        click.echo("\n".join(answer.lines))
    return 0 if answer.good else 1


@click.command()
@option("--radius", POSITIVE_LENGTH, "Radius of the object.", required=True)
@overpressure_option
@option(
    "--payload",
    MASS,
    "Mass of the object; whether it is held is computed, which takes some seconds.",
)
@option(
    "--friction",
    POSITIVE_NUMBER,
    "Friction coefficient of tube and object. [default: the node's]",
    metavar="MU",
)
@node_option
@output_options
def plan(
    radius: float,
    overpressure: float | None,
    payload: float | None,
    friction: float | None,
    namespace: str,
) -> int:
    """Ask a running node whether it can wrap an object, and at which pressure; nothing moves.

    The exit code is 0 if the node can wrap the object (and hold the payload), 1 if not, 2 if no
    node answers.
    """
    side = load_ros_side(SIDE)
    quick = payload is None and friction is None
    with progress_bar("the node computes the grip on this object", quiet=quick) as wait:
        wait(0, None)
        answer = side.plan(namespace, radius, overpressure, payload, friction)
    return _show(answer)


@click.command()
@option(
    "--radius", POSITIVE_LENGTH, "Radius of the object.  [default: the one that the node follows]"
)
@overpressure_option
@timeout_option
@option(
    "--on-failure",
    click.Choice(("vent", "hold")),
    "What to do with the pressure after a failure.  [default: the node's grasp.abort_policy]",
)
@node_option
@output_options
def grasp(
    radius: float | None,
    overpressure: float | None,
    timeout: float | None,
    on_failure: str | None,
    namespace: str,
) -> int:
    """Command a running node to wrap an object; wait until the object is held or the grasp failed.

    The gripper holds the object after this command has ended, until `release`. Ctrl-C cancels the
    grasp; --on-failure decides whether the pressure is vented or held then. The exit code is 0 if
    the object is held, 1 if not, 2 if no node answers.
    """
    side = load_ros_side(SIDE)
    answer = side.grasp(namespace, radius, overpressure, timeout, on_failure)
    return _show(answer)


@click.command()
@timeout_option
@node_option
@output_options
def release(timeout: float | None, namespace: str) -> int:
    """Command a running node to vent, and wait until the pressure is gone.

    The exit code is 0 if the pressure is gone, 1 if not, 2 if no node answers.
    """
    return _show(load_ros_side(SIDE).release(namespace, timeout))


@click.command()
@node_option
@output_options
def status(namespace: str) -> int:
    """Show what a running node does now, and why.

    The exit code is 0 if nothing is wrong, 1 if something is, 2 if no node answers.
    """
    return _show(load_ros_side(SIDE).status(namespace))


@click.command()
@option(
    "--duration",
    POSITIVE_NUMBER,
    "Time after which to end.  [default: at Ctrl-C]",
    metavar="SECONDS",
)
@node_option
@units_option
def watch(duration: float | None, namespace: str) -> int:
    """Show what a running node does, until Ctrl-C."""
    return int(load_ros_side(SIDE).watch(namespace, math.inf if duration is None else duration))
