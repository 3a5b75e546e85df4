# SPDX-License-Identifier: Apache-2.0
"""Every source file names its license in one line at its top."""

from __future__ import annotations

from repo.source_tree import PACKAGES, ROOT, pyproject

LINE = f"SPDX-License-Identifier: {pyproject()['project']['license']}"
SUFFIXES = {".action", ".cmake", ".msg", ".py", ".pyi", ".sh", ".srv", ".xacro"}
FOLDERS = ("benchmarks", "docs", "examples", "packaging", "tests", *PACKAGES)
BUILT = {"__pycache__", "_site", "build", "install", "log"}


def test_every_source_file_names_its_license() -> None:
    below = [path.relative_to(ROOT) for name in FOLDERS for path in (ROOT / name).rglob("*.*")]
    paths = [
        p
        for p in below
        if {p.suffix, p.name} & (SUFFIXES | {"CMakeLists.txt"}) and not BUILT & {*p.parts}
    ]
    assert {path.suffix for path in paths} == SUFFIXES | {".txt"}
    for path in (ROOT / "Makefile", *(ROOT / path for path in paths)):
        top = path.read_text(encoding="utf-8").splitlines()[:2]
        assert any(LINE in line for line in top), f'{path}: add "# {LINE}" as the first line'
