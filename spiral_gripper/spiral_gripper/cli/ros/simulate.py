# SPDX-License-Identifier: Apache-2.0
"""The command ``simulate``: the node without hardware; needs ROS 2, but not ``ros2 launch``."""

from __future__ import annotations

import math
import re
from functools import partial

import click

from spiral_gripper.cli.ros.side import load_ros_side
from spiral_gripper.cli.types import POSITIVE_NUMBER, QuantityType, option, units_option

FAULTS = ("none", "leak", "stuck_valve", "lost_link")
DEFAULT_GRIPPER = "paper_design_70"
# DDS's names have at most 255 characters; those of our topics and services need their part.
NAMESPACE_LENGTH_MAX = 150
_NAMESPACE = re.compile(r"/|(?!.*__)/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")


def checked_namespace(
    context: click.Context, option: click.Parameter, name: str | None
) -> str | None:
    """Return the namespace that an option has; nothing for none.

    Raises:
        click.BadParameter: it is no namespace.
    """
    del context, option
    if name is not None and not _NAMESPACE.fullmatch(name):
        raise click.BadParameter(
            "it must be names of letters, digits and single _, none beginning with a digit, "
            f"separated by single /, got {name!r}",
            param_hint="--namespace",
        )
    if name is not None and len(name) > NAMESPACE_LENGTH_MAX:
        raise click.BadParameter(
            f"it must have at most {NAMESPACE_LENGTH_MAX} characters", param_hint="--namespace"
        )
    return name


namespace_option = partial(option, "--namespace", str, metavar="NAME", callback=checked_namespace)


@click.command()
@click.argument("gripper", metavar="[GRIPPER]", default=DEFAULT_GRIPPER)
@option(
    "--radius",
    QuantityType("LENGTH", above=0.0, most="1 m"),
    "Radius of the object.  [default: the middle of the gripper's range]",
)
@option(
    "--noise",
    QuantityType("LENGTH", least=0.0, most="0.1 m"),
    "Standard deviation of the radius estimates.",
)
@option("--fault", click.Choice(FAULTS), "Fault of the regulator.", default="none")
@option(
    "--duration",
    POSITIVE_NUMBER,
    "Time after which to end.  [default: at Ctrl-C]",
    metavar="SECONDS",
)
@namespace_option("Namespace of all topics.  [default: a new one]")
@units_option
def simulate(
    gripper: str,
    radius: float | None,
    noise: float | None,
    fault: str,
    duration: float | None,
    namespace: str | None,
) -> int:
    """Start the node with a simulated regulator, gripper and object, and show what they do.

    GRIPPER is the name of a shipped gripper or the path of a description file. Ctrl-C vents the
    gripper and ends node and simulation. The exit code is 0 if both ended as they should, 1 if not.
    """
    from spiral_gripper.files.description import load_gripper

    load_gripper(gripper)  # a bad description is refused before anything is started
    session = load_ros_side("tools.simulate")
    settings = {"radius": radius, "estimate_noise": noise, "fault": fault}
    given = {name: value for name, value in settings.items() if value is not None}
    duration = math.inf if duration is None else duration
    return int(session.simulate(gripper, given, duration, namespace))


@click.command()
@click.argument("fault", type=click.Choice(FAULTS))
@namespace_option("Namespace of the simulation's topics.", required=True)
def inject(fault: str, namespace: str) -> int:
    """Set the FAULT of the regulator in the simulation of a namespace; none removes the fault."""
    return int(load_ros_side("tools.injection").inject(namespace, fault))
