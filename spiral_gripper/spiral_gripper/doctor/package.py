# SPDX-License-Identifier: Apache-2.0
"""The doctor's checks of this project's packages: how they were installed, with ROS or not."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote, urlparse

from spiral_gripper.doctor.checks import Facts, Finding, Mark

DISTRIBUTION = "spiral-gripper"
PACKAGE = "spiral_gripper"
ROS_PACKAGE = "spiral_gripper_ros"
# ROS 2 exists on PyPI for Linux on this processor and for Python before this version.
WHEELS_ARCHITECTURE = "x86_64"
NO_WHEELS_FROM = (3, 14)


@dataclass(frozen=True, slots=True)
class Installation:
    """How this project's packages were installed.

    Attributes:
        version: of the distribution; None if Python knows of none.
        source: the folder it was installed from; empty if not from one.
        editable: whether that folder's files are used in place.
        location: the folder that Python's record of the distribution lies in.
        package: the folder that the package is imported from.
    """

    version: str | None
    source: str
    editable: bool
    location: Path
    package: Path

    @classmethod
    def here(cls) -> Installation:
        """Return the installation of this process."""
        spec = find_spec(PACKAGE)
        origin = "" if spec is None or spec.origin is None else spec.origin
        package = Path(origin).parent
        try:
            distribution = metadata.distribution(DISTRIBUTION)
        except metadata.PackageNotFoundError:
            return cls(None, "", False, Path(), package)
        origin_text = distribution.read_text("direct_url.json") or "{}"
        direct = json.loads(origin_text)
        return cls(
            version=distribution.version,
            source=unquote(urlparse(direct.get("url", "")).path),
            editable=bool(direct.get("dir_info", {}).get("editable", False)),
            location=Path(str(distribution.locate_file(""))),
            package=package,
        )


def check_package(facts: Facts, installation: Installation | None = None) -> Finding:
    """Check how the packages were installed, and whether they are installed only once."""
    found = Installation.here() if installation is None else installation
    if found.version is None:
        return Finding(
            Mark.WARNING,
            f"imported from {found.package}, but not installed",
            "The code in that folder runs. To install, from a clone of the repository:",
            ("make install",),
        )
    text = f"{found.version}, {_kind(found, facts)}"
    others = [copy for copy in copies_of(PACKAGE, facts) if not _same(copy, found.package)]
    if others:
        return Finding(
            Mark.WARNING,
            f"{text}; also in {', '.join(str(copy) for copy in others)}",
            "Two installations: the first on Python's path is used, whichever you meant. Leave one "
            "out of PYTHONPATH, or start from a new terminal.",
        )
    return Finding(Mark.OK, text)


def copies_of(package: str, facts: Facts) -> list[Path]:
    """Return the different folders on Python's path that hold a package, in order."""
    folders: list[Path] = []
    for entry in facts.search_path:
        folder = entry / package
        if not (folder / "__init__.py").is_file():
            continue
        if not any(_same(folder, known) for known in folders):
            folders.append(folder)
    return folders


def has_ros_part() -> bool:
    """Return whether the node's package is installed; a folder of that name alone is none."""
    spec = find_spec(ROS_PACKAGE)
    return spec is not None and spec.origin is not None


def why_no_ros(facts: Facts) -> Finding:
    """Return why the node is not installed, and how to install it."""
    text = "not installed: the mechanics and the command line are, the node is not"
    if facts.system != "Linux" or facts.architecture != WHEELS_ARCHITECTURE:
        return Finding(
            Mark.INFO,
            f"{text}; PyPI has ROS 2 for Linux x86_64 only",
            "Where ROS 2 is installed in another way, build this repository in its workspace:",
            ("colcon build --packages-up-to spiral_gripper_ros",),
        )
    if facts.python >= NO_WHEELS_FROM:
        version = ".".join(str(part) for part in facts.python[:2])
        return Finding(
            Mark.INFO,
            f"{text}; PyPI has ROS 2 for Python 3.10 to 3.13, this is {version}",
            "For the node, from a clone of the repository:",
            ("make distclean", "make install PYTHON=python3.13"),
        )
    return Finding(
        Mark.INFO,
        f"{text}; it was left out when this was installed (SPIRAL_WITHOUT_ROS)",
        "For the node, from a clone of the repository:",
        ("env -u SPIRAL_WITHOUT_ROS make install",),
    )


def _kind(found: Installation, facts: Facts) -> str:
    """Return in words how it was installed."""
    if found.editable:
        return f"editable, from {found.source}"
    workspaces = [
        Path(entry).parent
        for entry in facts.environ.get("COLCON_PREFIX_PATH", "").split(os.pathsep)
        if entry
    ]
    for workspace in workspaces:
        if found.location.is_relative_to(workspace):
            return f"built by colcon in {workspace}"
    return f"a wheel, in {found.location}"


def _same(one: Path, other: Path) -> bool:
    return one.resolve() == other.resolve()
