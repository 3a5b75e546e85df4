# SPDX-License-Identifier: Apache-2.0
"""The doctor's checks of Python, and the libraries."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module, metadata

from spiral_gripper.doctor.checks import Check, Facts, Finding, Mark, first_line, normalized
from spiral_gripper.doctor.package import DISTRIBUTION, check_package, has_ros_part, why_no_ros

SECTION = "Installation"
OLDEST_PYTHON = (3, 10)
# What the mechanics need: the module, and the distribution that holds it.
LIBRARIES = (
    ("numpy", "numpy"),
    ("scipy", "scipy"),
    ("numba", "numba"),
    ("pint", "pint"),
    ("ruamel.yaml", "ruamel-yaml"),
)


def checks(facts: Facts) -> tuple[Check, ...]:
    """Return the checks of this table, the same for all facts."""
    del facts
    table = (
        Check("install.python", "Python", check_python),
        Check("install.package", "spiral_gripper", check_package),
        Check("install.libraries", "libraries", check_libraries),
        Check("install.pictures", "pictures", check_pictures),
    )
    if has_ros_part():
        return table
    return (*table, Check("install.ros", "ROS 2", why_no_ros))


def check_python(facts: Facts) -> Finding:
    """Check the version of Python and the platform."""
    version = ".".join(str(part) for part in facts.python)
    text = f"{version} on {facts.system} {facts.architecture}, in {facts.prefix}"
    if facts.python >= OLDEST_PYTHON:
        return Finding(Mark.OK, text)
    advice = "It must be 3.10 or newer. With another interpreter:"
    return Finding(Mark.PROBLEM, text, advice, ("make install PYTHON=python3.12",))


def check_libraries(
    facts: Facts, load: Callable[[str], object] = import_module, requirements: Iterable[str] = ()
) -> Finding:
    """Check whether the libraries are installed, can be imported, and are new enough.

    Args:
        facts: what is installed.
        load: imports a module.
        requirements: lines such as "numpy>=1.26"; none: those that our distribution states.
    """
    old = too_old(facts.distributions, requirements or _own_requirements())
    wrong = {name: f"{name} {facts.distributions[name]} is older than {old[name]}" for name in old}
    for module, name in LIBRARIES:
        if name not in facts.distributions:
            wrong[name] = f"{name} is not installed"
            continue
        try:
            load(module)
        except Exception as error:
            wrong[name] = f"{name} does not import: {first_line(str(error))}"
    if not wrong:
        versions = (f"{name} {facts.distributions[name]}" for _, name in LIBRARIES)
        return Finding(Mark.OK, ", ".join(versions))
    names = " ".join(sorted({*wrong, "numpy"}))  # most that do not import want another numpy
    return Finding(
        Mark.PROBLEM,
        "; ".join(wrong.values()),
        "Install versions that fit together:",
        (f"{facts.prefix}/bin/python -m pip install --upgrade {names}",),
    )


def too_old(distributions: Mapping[str, str], requirements: Iterable[str]) -> dict[str, str]:
    """Return the distributions that are older than required, with the version that would do.

    Args:
        distributions: installed versions by normalized name.
        requirements: lines such as "numpy>=1.26"; those of extras do not count.

    Example:
        >>> too_old({"numpy": "1.9.3", "scipy": "1.11"}, ["numpy>=1.26", "scipy>=1.11"])
        {'numpy': '1.26'}
    """
    found = {}
    for line in requirements:
        stated = re.fullmatch(r"\s*([\w.-]+)\s*>=\s*([\d.]+)\s*", line)
        if stated is None:
            continue
        name, least = normalized(stated[1]), stated[2]
        if name in distributions and _numbers(distributions[name]) < _numbers(least):
            found[name] = least
    return found


def check_pictures(facts: Facts) -> Finding:
    """Check whether the extra for pictures is installed."""
    if "matplotlib" in facts.distributions:
        return Finding(Mark.OK, f"matplotlib {facts.distributions['matplotlib']}")
    advice = "Needed for --plot and for reports only:"
    return Finding(
        Mark.INFO,
        "matplotlib is not installed",
        advice,
        (f"{facts.prefix}/bin/python -m pip install '{DISTRIBUTION}[plot]'",),
    )


def _own_requirements() -> list[str]:
    """Return what our distribution states; nothing where colcon installed it."""
    try:
        return metadata.requires(DISTRIBUTION) or []
    except metadata.PackageNotFoundError:
        return []


def _numbers(version: str) -> tuple[int, ...]:
    """Return the leading numbers of a version, as many as compare well."""
    found = re.match(r"\d+(\.\d+)*", version)
    return () if found is None else tuple(int(part) for part in found[0].split("."))
