# SPDX-License-Identifier: Apache-2.0
"""Every source file names its license in one line at its top."""

from __future__ import annotations

from repo.source_tree import PACKAGES, ROOT, pyproject

LINE = f"SPDX-License-Identifier: {pyproject()['project']['license']}"
SUFFIXES = {".action", ".cmake", ".msg", ".py", ".pyi", ".sh", ".srv", ".xacro"}
NAMES = {"CMakeLists.txt", "Makefile"}
FOLDERS = ("benchmarks", "docs", "examples", "packaging", "tests")
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


def test_every_source_file_names_its_license() -> None:
    names = source_files()
    assert all(any(name.endswith(end) for name in names) for end in SUFFIXES | NAMES)
    for name in names:
        top = (ROOT / name).read_text(encoding="utf-8").splitlines()[:2]
        assert any(LINE in line for line in top), f'{name}: add "# {LINE}" as the first line'
