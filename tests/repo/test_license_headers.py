# SPDX-License-Identifier: Apache-2.0
"""Every source file names its license in one line at its top."""

from repo.source_tree import PACKAGES, ROOT, pyproject

LINE = f"SPDX-License-Identifier: {pyproject()['project']['license']}"
KINDS = {"CMakeLists.txt", ".action", ".cmake", ".msg", ".py", ".pyi", ".sh", ".srv", ".xacro"}
FOLDERS = ("benchmarks", "docs", "examples", "packaging", "tests", *PACKAGES)
BUILT = {"__pycache__", "_site", "build", "install", "log"}


def test_every_source_file_names_its_license():
    paths = [
        path
        for name in FOLDERS
        for path in (ROOT / name).rglob("*.*")
        if {path.suffix, path.name} & KINDS and not BUILT & {*path.relative_to(ROOT).parts}
    ]
    assert {path.suffix for path in paths} == KINDS - {"CMakeLists.txt"} | {".txt"}
    for path in (ROOT / "Makefile", *paths):
        top = path.read_text("utf-8").splitlines()[:2]
        assert any(LINE in line for line in top), f'{path}: add "# {LINE}" as the first line'
