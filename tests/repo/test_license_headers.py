# SPDX-License-Identifier: Apache-2.0
"""Every source file names its license in one line at its top."""

from __future__ import annotations

import pytest
from repo.source_tree import ROOT, pyproject

LINE = f"SPDX-License-Identifier: {pyproject()['project']['license']}"
SUFFIXES = {".action", ".cmake", ".msg", ".py", ".pyi", ".sh", ".srv", ".xacro"}
NAMES = {"CMakeLists.txt", "Makefile"}
FOLDERS = ("benchmarks", "docs", "examples", "packaging", "tests")
PACKAGES = ("spiral_core", "spiral_gripper", "spiral_gripper_msgs", "spiral_gripper_ros")
BUILT = {"__pycache__", "_site", "build", "install", "log"}


def source_files() -> list[str]:
    """Return the source files, relative to the root."""
    paths = [ROOT / "Makefile", *(p for f in (*FOLDERS, *PACKAGES) for p in (ROOT / f).rglob("*"))]
    return sorted(
        str(path.relative_to(ROOT))
        for path in paths
        if (path.suffix in SUFFIXES or path.name in NAMES)
        and path.is_file()
        and not BUILT.intersection(path.relative_to(ROOT).parts)
    )


def test_there_are_sources_of_each_kind() -> None:
    names = source_files()
    assert all(any(name.endswith(end) for name in names) for end in SUFFIXES | NAMES)


@pytest.mark.parametrize("name", source_files())
def test_a_source_file_names_its_license(name: str) -> None:
    with (ROOT / name).open(encoding="utf-8") as file:
        top = [file.readline() for _ in range(2)]
    assert any(LINE in line for line in top), f'add "# {LINE}" as the first line'
