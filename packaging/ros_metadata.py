# SPDX-License-Identifier: Apache-2.0
"""Decide at build time whether the distribution carries ROS 2 (read by /pyproject.toml).

ROS 2 exists on PyPI as wheels for Linux x86-64 and CPython 3.10 to 3.13. Elsewhere, and where
the environment variable ``SPIRAL_WITHOUT_ROS`` is set, ``pip install .`` gives the mechanics and
the edge alone: neither ROS requirements nor the node's console scripts. The conditions are those
of ``[[tool.scikit-build.overrides]]`` in ``pyproject.toml``, which drops the ROS packages.

``SPIRAL_ROS_DISTRO=kilted`` replaces the wheels of Jazzy, which pyproject.toml names, by those of
Kilted. ``make kilted`` builds and tests with them.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Mapping
from typing import Any

# Wheels of Jazzy that Kilted no longer has, and one that its generators need.
NOT_IN_KILTED = {"ros-jazzy-fastrtps-cmake-module", "ros-jazzy-python-cmake-module"}
ONLY_IN_KILTED = {"ros-jazzy-ament-cmake-ros": "ros-jazzy-ament-cmake-ros-core"}


def for_distribution(requirements: list[str]) -> list[str]:
    """Return requirements with the ROS wheels of the distribution that is chosen."""
    chosen = os.environ.get("SPIRAL_ROS_DISTRO", "jazzy")
    if chosen == "jazzy":
        return requirements
    if chosen != "kilted":
        raise SystemExit(f"SPIRAL_ROS_DISTRO must be jazzy or kilted, got {chosen}")
    kept = [line for line in requirements if line not in NOT_IN_KILTED]
    kept += [more for line, more in ONLY_IN_KILTED.items() if line in kept]
    return [line.replace("ros-jazzy-", "ros-kilted-") for line in kept]


def with_ros() -> bool:
    """Return whether ROS 2 wheels exist here and are wanted."""
    unwanted = os.environ.get("SPIRAL_WITHOUT_ROS", "").lower()
    return (
        unwanted in {"", "0", "n", "no", "off", "false", "f"}
        and sys.platform == "linux"
        and platform.machine() == "x86_64"
        and sys.version_info < (3, 14)
    )


def dynamic_metadata(settings: Mapping[str, Any], project: Mapping[str, Any]) -> dict[str, Any]:
    """Return the ``[project]`` fields that depend on ROS."""
    del project
    dependencies, scripts = list(settings["dependencies"]), dict(settings["scripts"])
    if with_ros():
        dependencies += for_distribution(settings["ros-dependencies"])
        scripts |= settings["ros-scripts"]
    return {"dependencies": dependencies, "scripts": scripts}


def dynamic_wheel(settings: Mapping[str, Any]) -> dict[str, bool]:
    """Report that wheels built from one source distribution may require different things."""
    del settings
    return {"dependencies": True, "scripts": True}


if __name__ == "__main__":  # for the Makefile and its scripts
    sys.stdout.write("yes\n" if with_ros() else "no\n")
