# SPDX-License-Identifier: Apache-2.0
"""The doctor's check that the compiled interfaces have what this code uses.

After an upgrade the Python files may be new and the compiled messages old; the node then fails on
an interface or a constant that they do not have.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from spiral_gripper.doctor.checks import Facts, Finding, Mark, first_line
from spiral_gripper_ros.control.states import Reason, State

PACKAGE = "spiral_gripper_msgs"
# Imports every interface that the node uses.
NODE = "spiral_gripper_ros.node.gripper_node"


def check_interfaces(facts: Facts, load: Callable[[str], Any] = import_module) -> Finding:
    """Check whether the compiled interfaces exist, and have what this version uses.

    Args:
        facts: how this was installed.
        load: imports a module.
    """
    try:
        status = load(f"{PACKAGE}.msg").GripStatus
        load(NODE)
    except (ImportError, AttributeError) as error:
        return Finding(Mark.PROBLEM, f"{PACKAGE}: {first_line(str(error))}", *_rebuild(facts))
    lacking = missing_constants(status)
    if lacking:
        text = f"compiled from another version: GripStatus has no {', '.join(lacking)}"
        return Finding(Mark.PROBLEM, text, *_rebuild(facts))
    return Finding(Mark.OK, "all that this version of the node uses")


def missing_constants(status: Any) -> list[str]:  # noqa: ANN401
    """Return the states and reasons that a compiled ``GripStatus`` does not have."""
    wanted = [f"{kind.__name__.upper()}_{item.name}" for kind in (State, Reason) for item in kind]
    return [name for name in wanted if not hasattr(status, name)]


def _rebuild(facts: Facts) -> tuple[str, tuple[str, ...]]:
    """Return how the interfaces are compiled, in words and as a command."""
    if facts.environ.get("COLCON_PREFIX_PATH"):
        command = "colcon build --cmake-clean-cache --packages-select spiral_gripper_msgs"
        return "Compile them, in the workspace, and source its setup file again:", (command,)
    return "Compile them, in the clone of the repository that this comes from:", ("make install",)
