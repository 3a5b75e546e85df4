# SPDX-License-Identifier: Apache-2.0
"""Compiled kernels are cached on disk, and a changed source file makes it stale."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

import spiral_core
from spiral_core.numerics.kernel import KERNEL_FILES

pytestmark = pytest.mark.long

# The folder comes before any editable install of the package.
CALL = """
import sys
from importlib.machinery import PathFinder
sys.meta_path.insert(0, PathFinder)
sys.path.insert(0, {folder!r})
from spiral_core.rod import _system as rod_system
assert rod_system.__file__.startswith({folder!r})
print(repr(rod_system.discrete_strain_scale(2.0)))
"""


def run(folder: Path) -> float:
    """Return what a kernel of the package in ``folder`` gives, in a process of its own."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA")}
    code = CALL.format(folder=str(folder))
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, env=environment
    )
    return float(done.stdout)


def test_a_changed_kernel_recompiles_the_kernels_that_call_it(tmp_path: Path) -> None:
    """Otherwise an update of one file would leave the old physics in the others, silently."""
    source = Path(spiral_core.__file__).parent
    package = tmp_path / "spiral_core"
    shutil.copytree(source, package, ignore=shutil.ignore_patterns("__pycache__"))
    before = run(tmp_path)
    assert list(package.rglob("__pycache__/*.nbi"))
    assert run(tmp_path) == before
    element = package / "rod" / "_element.py"
    text = element.read_text()
    assert text.count("1.0 / 6.0 + s * (3.0 / 40.0") == 1
    element.write_text(text.replace("1.0 / 6.0 + s * (3.0 / 40.0", "1.0 / 5.0 + s * (3.0 / 40.0"))
    assert run(tmp_path) > before + 0.01


def test_kernels_read_only_files_that_the_digest_covers() -> None:
    """A kernel that read a constant or called a kernel of another file could be stale."""
    covered = {str(path) for path in KERNEL_FILES}
    checked = set()
    for path in Path(spiral_core.__file__).parent.rglob("*.py"):
        source = path.read_text()
        if path.name == "kernel.py" or "numerics.kernel import" not in source:
            continue
        assert str(path) in covered
        tree = ast.parse(source)
        origins = {
            name.asname or name.name: each.module
            for each in tree.body
            if isinstance(each, ast.ImportFrom) and (each.module or "").startswith("spiral_core.")
            for name in each.names
        }
        module = ".".join(
            path.relative_to(Path(spiral_core.__file__).parents[1]).with_suffix("").parts
        )
        for value in vars(import_module(module)).values():
            if not isinstance(value, Dispatcher) or value.py_func.__module__ != module:
                continue
            checked.add(path)
            for name in origins.keys() & set(value.py_func.__code__.co_names):
                origin = Path(str(import_module(str(origins[name])).__file__))
                assert str(origin) in covered, f"{module}.{value.py_func.__name__} reads {name}"
    assert {path.name for path in checked} >= {"_element.py", "_newton.py", "_kernels.py"}
