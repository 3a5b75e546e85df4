"""The doctor's check of the compiled interfaces: are they those that this code is written for?

The usual trap after an upgrade: Python's files are new, the compiled messages are still the old
ones, and the node fails on a field that they do not have.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from importlib import import_module
from typing import Any

from spiral_gripper.doctor.checks import Facts, Finding, Mark, first_line
from spiral_gripper_ros.control.states import Reason, State

PACKAGE = "spiral_gripper_msgs"
# Digests of the fields and constants of the interfaces that this code is written for. A test
# compares them with those that are compiled from the sources, and says what to write here.
INTERFACES = {
    "action.Grasp": "0cd66f01",
    "action.Release": "d2b7fbfb",
    "msg.DesignChange": "0f357cb5",
    "msg.DesignMargin": "314a1478",
    "msg.DesignStep": "e827bdfb",
    "msg.GripStatus": "957ff345",
    "msg.ObjectRadius": "dbb06351",
    "msg.Winding": "8f747d35",
    "srv.DesignGripper": "7f79eb00",
    "srv.PlanWrap": "b701b95f",
}
_PARTS = {"msg": ("",), "srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}


def check_interfaces(facts: Facts, load: Callable[[str], Any] = import_module) -> Finding:
    """Look whether the compiled interfaces are there, and are those of this version.

    Args:
        facts: how this was installed.
        load: imports a module.
    """
    try:
        modules = {kind: load(f"{PACKAGE}.{kind}") for kind in _PARTS}
    except ImportError as error:
        return Finding(Mark.PROBLEM, f"{PACKAGE}: {first_line(str(error))}", *_rebuild(facts))
    different = []
    for name, digest in INTERFACES.items():
        kind, _, interface = name.partition(".")
        compiled = getattr(modules[kind], interface, None)
        if compiled is None:
            different.append(f"{interface} is missing")
        elif digest_of(kind, compiled) != digest:
            different.append(f"{interface} differs")
    if different:
        lacking = missing_constants(getattr(modules["msg"], "GripStatus", None))
        more = f" (no {', '.join(lacking)})" if lacking else ""
        return Finding(
            Mark.PROBLEM,
            f"compiled from another version: {', '.join(different)}{more}",
            *_rebuild(facts),
        )
    return Finding(Mark.OK, f"{len(INTERFACES)} interfaces, of the version of this Python code")


def digest_of(kind: str, compiled: Any) -> str:  # noqa: ANN401
    """Return a digest of an interface's fields and constants.

    Args:
        kind: "msg", "srv" or "action".
        compiled: the compiled class.
    """
    lines = []
    for part in _PARTS[kind]:
        message = getattr(compiled, part) if part else compiled
        lines += [
            f"{part} {name} {of}" for name, of in message.get_fields_and_field_types().items()
        ]
        lines += [f"{part} {name}={value}" for name, value in constants_of(message).items()]
    return hashlib.sha256("\n".join(sorted(lines)).encode()).hexdigest()[:8]


def constants_of(message: Any) -> dict[str, object]:  # noqa: ANN401
    """Return the constants of a compiled message."""
    return {
        name: value
        for name, value in vars(message).items()
        if name.isupper() and isinstance(value, (bool, int, float, str))
    }


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
