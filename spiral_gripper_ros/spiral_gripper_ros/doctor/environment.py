# SPDX-License-Identifier: Apache-2.0
"""The doctor's checks of the ROS 2 installation: its distribution, and mixtures of two.

Whatever is wrong here makes loading ROS fail, or ends the process, with a message that does not say
so; therefore it is looked at before anything of ROS is loaded. Knows no ROS.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from pathlib import Path

from spiral_gripper.doctor.checks import Facts, Finding, Mark
from spiral_gripper.doctor.package import copies_of

# What this package is tested with, and what its code is written for too.
TESTED, ALSO = "jazzy", "kilted"
# What a sourced setup file leaves in a shell, and the command without that.
SOURCED = ("ROS_DISTRO", "AMENT_PREFIX_PATH", "PYTHONPATH", "LD_LIBRARY_PATH")
WITHOUT_SOURCED = f"env {' '.join(f'-u {name}' for name in SOURCED)} spiral-gripper doctor"
# The wheels of ROS 2 start Python a second time, with the folders of their libraries; this variable
# says that it has been done.
BOOTSTRAPPED = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"
_WHEEL = re.compile(r"ros-(\w+)-rclpy")
_MIDDLEWARES = "share/ament_index/resource_index/rmw_typesupport"


def check_distribution(facts: Facts) -> Finding:
    """Check which ROS 2 is used, and whether parts of another one interfere."""
    wheels = sorted(m[1] for name in facts.distributions if (m := _WHEEL.fullmatch(name)))
    copies = copies_of("rclpy", facts)
    if not copies:
        return _no_rclpy(facts)
    if len(wheels) > 1:
        return Finding(
            Mark.PROBLEM,
            f"wheels of {' and '.join(wheels)} in one environment have overwritten each other",
            "Make the environment anew, with one of them. In a clone of the repository:",
            ("make distclean", "make install"),
        )
    other = _python_of(copies[0])
    if other not in (None, facts.python[:2]):
        return Finding(
            Mark.PROBLEM,
            f"{copies[0]} is for another Python than this {_dotted(facts.python[:2])}",
            "A sourced setup file has put it on Python's path. Without that:",
            (WITHOUT_SOURCED,),
        )
    name = wheels[0] if wheels else _distribution_of(copies[0], facts)
    sourced = facts.environ.get("ROS_DISTRO", "")
    if len(copies) > 1 or (wheels and sourced):
        return _mixed(name, sourced, copies)
    place = f"wheels in {facts.prefix}" if wheels else f"from {copies[0]}"
    if name not in (TESTED, ALSO):
        return Finding(
            Mark.WARNING,
            f"{name or 'unknown'}, {place}",
            f"This package is tested with {TESTED} and written for {ALSO} too.",
        )
    return Finding(Mark.OK, f"{name}, {place}")


def check_start(facts: Facts) -> Finding:
    """Check whether libraries are found, and whether the folders of a sourced setup exist."""
    libraries = facts.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)
    from_wheels = any(_WHEEL.fullmatch(name) for name in facts.distributions)
    if from_wheels and BOOTSTRAPPED in facts.environ and str(facts.prefix / "lib") not in libraries:
        return Finding(
            Mark.PROBLEM,
            f"{BOOTSTRAPPED} was set by another Python: this one will not find ROS's libraries",
            "Remove it:",
            (f"unset {BOOTSTRAPPED}",),
        )
    prefixes = [part for part in _prefix_path(facts) if part]
    gone = [part for part in prefixes if not Path(part).is_dir()]
    if gone:
        return Finding(
            Mark.WARNING,
            f"AMENT_PREFIX_PATH names folders that do not exist: {', '.join(gone)}",
            "A workspace that was sourced has been moved or removed; start from a new terminal.",
        )
    if prefixes:
        return Finding(Mark.OK, f"AMENT_PREFIX_PATH: {', '.join(_folded(prefixes))}")
    return Finding(Mark.OK, "AMENT_PREFIX_PATH is not set, and need not be")


def check_middleware_name(facts: Facts) -> Finding:
    """Check whether the selected middleware is installed."""
    wanted = facts.environ.get("RMW_IMPLEMENTATION", "")
    prefixes = [str(facts.prefix), *_prefix_path(facts)]
    installed = sorted(
        {
            file.name
            for prefix in prefixes
            for file in Path(prefix, _MIDDLEWARES).glob("rmw_*")
            if prefix and file.name != "rmw_implementation"
        }
    )
    if not wanted:
        return Finding(Mark.OK, f"the default one; installed: {', '.join(installed) or 'unknown'}")
    if installed and wanted not in installed:
        return Finding(
            Mark.PROBLEM,
            f"RMW_IMPLEMENTATION={wanted} is not installed; installed: {', '.join(installed)}",
            "All nodes that communicate need the same middleware. For the installed one:",
            ("unset RMW_IMPLEMENTATION",),
        )
    return Finding(Mark.OK, f"{wanted}, from RMW_IMPLEMENTATION")


def _no_rclpy(facts: Facts) -> Finding:
    """Return what to do where the node is installed and rclpy is not."""
    installed = sorted(facts.root.glob("opt/ros/*/setup.bash"))
    if installed:
        return Finding(
            Mark.PROBLEM,
            f"not on Python's path, but installed in {installed[-1].parent}",
            "In the terminal where the node is to run:",
            (f"source {installed[-1]}",),
        )
    return Finding(
        Mark.PROBLEM,
        "rclpy is not installed in this environment",
        "Its wheels come with the package. In a clone of the repository:",
        ("make install",),
    )


def _mixed(name: str, sourced: str, copies: list[Path]) -> Finding:
    """Return how bad it is that two installations of ROS 2 meet in one process."""
    places = ", ".join(str(copy) for copy in copies)
    if len(copies) > 1:
        text = f"rclpy is here {len(copies)} times, the first is used: {places}"
    else:
        text = f"{name} from wheels, and a setup file of {sourced} was sourced in this terminal"
    mark = Mark.WARNING if sourced in ("", name) else Mark.PROBLEM
    advice = (
        "Their libraries have the same names and may be taken from either. Without the sourced one:"
    )
    return Finding(mark, text, advice, (WITHOUT_SOURCED,))


def _distribution_of(rclpy: Path, facts: Facts) -> str:
    """Return the name of the distribution that rclpy belongs to; empty if nothing says it."""
    parts = rclpy.parts
    if "ros" in parts[:-1]:
        return parts[parts.index("ros") + 1]
    return facts.environ.get("ROS_DISTRO", "")


def _python_of(rclpy: Path) -> tuple[int, int] | None:
    """Return the version of Python in a path such as /opt/ros/x/lib/python3.12/site-packages."""
    found = re.search(r"/python(\d+)\.(\d+)/", rclpy.as_posix())
    return None if found is None else (int(found[1]), int(found[2]))


def _folded(prefixes: list[str]) -> list[str]:
    """Return folders, those of one workspace as one."""
    count = Counter(str(Path(prefix).parent) for prefix in prefixes)
    folded = [
        f"{parent}/* ({count[parent]})" if count[parent] > 1 else prefix
        for prefix in prefixes
        for parent in [str(Path(prefix).parent)]
    ]
    return list(dict.fromkeys(folded))


def _prefix_path(facts: Facts) -> list[str]:
    return facts.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)


def _dotted(version: tuple[int, ...]) -> str:
    return ".".join(str(part) for part in version)
