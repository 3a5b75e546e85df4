# SPDX-License-Identifier: Apache-2.0
"""Compiled kernels are cached on disk, and a changed source file makes it stale."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import spiral_core
from spiral_core.numerics.kernel import KERNEL_FILES

pytestmark = pytest.mark.long

SOURCE = Path(spiral_core.__file__).parent
# Two files of kernels, one of which calls the other.
INNER = """
from spiral_core.numerics.kernel import compiled
@compiled
def inner(x):
    return 2.0 * x
"""
OUTER = """
from spiral_core.numerics.kernel import compiled
from spiral_core.rod._inner import inner
@compiled
def outer(x):
    return 1.0 + inner(x)
"""
# The folder comes before any editable install of the package.
CALL = """
import sys
from importlib.machinery import PathFinder
sys.meta_path.insert(0, PathFinder)
sys.path.insert(0, sys.argv[1])
from spiral_core.rod._outer import outer
print(outer(3.0))
"""


def test_a_changed_kernel_recompiles_the_kernels_that_call_it(tmp_path):
    """Otherwise an update of one file would leave the old physics in the others, silently."""
    rod = tmp_path / "spiral_core" / "rod"
    shutil.copytree(SOURCE, rod.parent, ignore=shutil.ignore_patterns("__pycache__"))
    (rod / "_outer.py").write_text(OUTER)
    environment = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA")}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"  # its own cache knows whole seconds only
    for factor, expected in (("2.0", 7.0), ("2.0", 7.0), ("5.0", 16.0)):
        (rod / "_inner.py").write_text(INNER.replace("2.0", factor))
        command = [sys.executable, "-c", CALL, str(tmp_path)]
        done = subprocess.run(command, check=True, capture_output=True, env=environment)
        assert float(done.stdout) == expected
        assert list(rod.glob("__pycache__/_outer*.nbi"))


def test_kernels_read_only_files_that_the_digest_covers():
    """A kernel that read a constant or called a kernel of another file could be stale."""
    checked = set()
    for path in SOURCE.rglob("*.py"):
        tree = ast.parse(path.read_text())
        origins = {
            name.asname or name.name: each.module.replace(".", "/") + ".py"
            for each in tree.body
            if isinstance(each, ast.ImportFrom) and (each.module or "").startswith("spiral_core.")
            for name in each.names
        }
        for kernel in ast.walk(tree):
            marks = [ast.unparse(mark) for mark in getattr(kernel, "decorator_list", ())]
            if not {"compiled", "inlined"} & {*marks}:
                continue
            checked.add(path.name)
            read = {node.id for node in ast.walk(kernel) if isinstance(node, ast.Name)}
            files = {SOURCE.parent / origins[name] for name in origins.keys() & read}
            assert {path, *files} <= {*KERNEL_FILES}, kernel.name
    assert checked >= {"_element.py", "_newton.py", "_kernels.py"}
