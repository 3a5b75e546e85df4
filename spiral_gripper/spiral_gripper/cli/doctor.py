# SPDX-License-Identifier: Apache-2.0
"""The command ``doctor``: versions, kernels, grippers, a grip, and a node that answers."""

from __future__ import annotations

import math
import platform
import sys
from collections.abc import Callable
from functools import partial
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec

import click

from spiral_gripper.cli.output import print_json
from spiral_gripper.cli.types import output_options, wanted

LIBRARIES = ("numpy", "scipy", "numba", "ruamel.yaml", "matplotlib")
PAGE = "docs/troubleshooting.md lists causes and remedies"


@click.command()
@click.argument("gripper", metavar="[GRIPPER]", required=False)
@output_options
def doctor(gripper: str | None) -> int:
    """Check the installation, the grippers and the ROS 2 node.

    GRIPPER is the name of a shipped gripper or the path of a description file; without it all
    shipped ones are checked. Kernels that are not compiled yet are compiled. A node is started in
    a namespace of its own and asked to plan one wrap; no gripper is commanded.

    The exit code is 0 without problems and 1 with a problem.
    """
    from spiral_gripper.files.catalog import available_grippers

    names = available_grippers() if gripper is None else (gripper,)
    checks: dict[str, Callable[[], str]] = {
        "versions": check_versions,
        "kernels": check_kernels,
        **{name: partial(check_gripper, name) for name in names},
        "grip": partial(check_grip, names[0]),
        "node": partial(check_node, names[0]),
    }
    found: list[dict[str, object]] = []
    for name, check in checks.items():
        # The last two need all that is checked before them.
        if name in ("grip", "node") and any(each["problem"] for each in found):
            continue
        problem, text = _outcome(check)
        found.append({"name": name, "problem": problem, "text": text})
        if not wanted("json"):
            click.echo(f"{'PROBLEM' if problem else 'ok':<8} {name}: {text}")
    problems = sum(bool(each["problem"]) for each in found)
    if wanted("json"):
        print_json({"problems": problems, "checks": found})
    else:
        click.echo(f"problems: {problems}; {PAGE}" if problems else "all well")
    return 1 if problems else 0


def _outcome(check: Callable[[], str]) -> tuple[bool, str]:
    """Return whether a check raises, and what it says."""
    try:
        return False, check()
    except (Exception, SystemExit) as error:  # a broken library raises anything
        return True, f"{type(error).__name__}: {error}"


def check_versions() -> str:
    """Return the versions of Python and the libraries; those that are broken raise."""
    for name in LIBRARIES[:-1]:
        import_module(name)
    try:
        own = version("spiral-gripper")
    except PackageNotFoundError:
        own = "not installed by pip"
    known = [f"{name} {version(name)}" for name in LIBRARIES if find_spec(name) is not None]
    python = f"Python {platform.python_version()} on {platform.platform()}, in {sys.prefix}"
    return f"spiral_gripper {own}; {python}; {', '.join(known)}"


def check_kernels() -> str:
    """Compile the kernels, unless that has been done."""
    from spiral_gripper.kernels import compile_kernels, kernels_are_compiled

    if kernels_are_compiled():
        return "compiled"
    compile_kernels()
    if kernels_are_compiled():
        return "have been compiled"
    raise OSError("no folder for compiled kernels can be written: set NUMBA_CACHE_DIR")


def check_gripper(name: str) -> str:
    """Read a gripper's file and find which objects it wraps."""
    from spiral_core import WrapCurve
    from spiral_gripper.files.description import load_description
    from spiral_gripper.files.shown import shown, shown_range

    description = load_description(name)
    curve = WrapCurve(description.gripper)
    radii = shown_range(curve.radius_min, curve.radius_max)
    limit = shown(description.gripper.pressure_max, "Pa")
    found = f"tip criterion for radii from {radii}, up to {limit}"
    return "; ".join((found, *description.warnings))


def check_grip(name: str) -> str:
    """Wrap an object of middle radius, with contact and friction."""
    from spiral_core import grip_window, lay_into_coil
    from spiral_gripper.files.description import load_gripper
    from spiral_gripper.files.shown import shown

    radius = _middle_radius(name)
    onset = grip_window(lay_into_coil(load_gripper(name), radius)).onset_wrap
    if onset is None:
        raise ValueError(f"{name} holds no object of {shown(radius, 'm')}")
    return f"{name} wraps an object of {shown(radius, 'm')} from {shown(onset, 'Pa')}"


def check_node(name: str) -> str:
    """Start a node and ask it to plan one wrap."""
    if find_spec("rclpy") is None:
        return "not installed: ROS 2 is on PyPI for Linux x86-64 with Python 3.10 to 3.13 only"
    plan = import_module("spiral_gripper_ros.tools.one_answer").plan_by_new_node
    return str(plan(name, _middle_radius(name)))


def _middle_radius(name: str) -> float:
    """Return the geometric mean of the radii that a gripper grips [m]."""
    from spiral_core import WrapCurve
    from spiral_gripper.files.description import load_gripper

    curve = WrapCurve(load_gripper(name))
    return math.sqrt(curve.radius_min * curve.radius_max)
