# SPDX-License-Identifier: Apache-2.0
"""Check one colcon installation, in a shell that has sourced its setup.bash.

What ros2 run and ros2 launch look up, the imports, the description files, that the demo, which
starts the node, runs to its end, and that node and simulator grasp and release.

Usage: colcon_smoke.py INSTALL_FOLDER REPOSITORY
"""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from importlib import resources
from pathlib import Path

from ament_index_python.packages import get_package_prefix

PACKAGES = ("spiral_core", "spiral_gripper", "spiral_gripper_msgs", "spiral_gripper_ros")
EXECUTABLES = (
    "spiral_gripper_demo",
    "spiral_gripper_node",
    "spiral_gripper_regulator",
    "spiral_gripper_simulator",
)
# The first start of each compiles the kernels: minutes on a busy machine [s].
PATIENCE = 900.0
SHARED = ("config", "launch", "rviz", "security", "systemd", "urdf")


def require(condition: bool, complaint: str) -> None:
    """Stop with the complaint unless the condition holds."""
    if not condition:
        raise SystemExit(complaint)


def check_package(name: str, install: Path, root: Path) -> None:
    """Check where the index, the share folder and the import of a package lead."""
    prefix = Path(get_package_prefix(name)).resolve()
    require(prefix.is_relative_to(install), f"{name}: the index says {prefix}, not in {install}")
    require((prefix / "share" / name / "package.xml").is_file(), f"{name}: no package.xml in share")
    module = Path(str(importlib.import_module(name).__file__)).resolve()
    # A symlinked build leads to the sources and the build folder; none to what pip installed.
    from_workspace = module.is_relative_to(install.parent) or module.is_relative_to(root / name)
    require(from_workspace, f"{name}: imported from {module}")


def check_files(root: Path) -> None:
    """Check that description files, launch and other shared files, and executables are there."""
    config = root / "spiral_gripper/spiral_gripper/config"
    shipped = sorted(path.name for path in config.iterdir() if path.is_file())
    folder = resources.files("spiral_gripper") / "config"
    found = sorted(entry.name for entry in folder.iterdir() if entry.is_file())
    require(shipped != [] and found == shipped, f"files of grippers: {found}, not {shipped}")
    prefix = Path(get_package_prefix("spiral_gripper_ros"))
    for folder in SHARED:
        sources = [p for p in (root / "spiral_gripper_ros" / folder).iterdir() if p.is_file()]
        require(sources != [], f"nothing in {folder}")
        for source in sources:
            path = prefix / "share" / "spiral_gripper_ros" / folder / source.name
            require(path.is_file(), f"no {path}")
    for name in EXECUTABLES:
        path = prefix / "lib" / "spiral_gripper_ros" / name
        require(os.access(path, os.X_OK), f"no executable {path}")


def main() -> None:
    """Check the installation named on the command line."""
    install, root = (Path(argument).resolve() for argument in sys.argv[1:])
    os.chdir("/")
    for name in PACKAGES:
        check_package(name, install, root)
    check_files(root)
    demo = Path(get_package_prefix("spiral_gripper_ros"), "lib/spiral_gripper_ros", EXECUTABLES[0])
    subprocess.run([demo], check=True, timeout=PATIENCE)
    command = Path(get_package_prefix("spiral_gripper"), "bin/spiral-gripper")
    subprocess.run([command, "doctor"], check=True, timeout=PATIENCE)


if __name__ == "__main__":
    main()
