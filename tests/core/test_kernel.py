# SPDX-License-Identifier: Apache-2.0
"""Compiled kernels are cached on disk, and the cache knows what each kernel was made of."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import spiral_core
from spiral_core.numerics.kernel import content_stamp
from spiral_core.rod import _element as rod_element
from spiral_core.rod import _newton as rod_newton
from spiral_core.rod import _shape as rod_shape
from spiral_core.rod import _system as rod_system
from spiral_core.rod.contact import _element as contact_element

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


def test_the_stamp_of_a_kernel_covers_what_it_calls_and_reads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    kernel = rod_newton.minimize.py_func  # type: ignore[attr-defined]
    stamp = content_stamp.__wrapped__
    before = stamp(kernel)
    assert stamp(kernel) == before == content_stamp(kernel)
    monkeypatch.setattr(rod_newton, "STEP_LOOSENING", 20.0)
    assert stamp(kernel) != before
    monkeypatch.undo()
    monkeypatch.setattr(rod_newton, "newton_pass", rod_system.discrete_strain_scale)
    assert stamp(kernel) != before
    monkeypatch.undo()
    monkeypatch.setattr(rod_system.Solution, "_fields", rod_system.Solution._fields[::-1])
    assert stamp(kernel) != before
    monkeypatch.undo()
    chain = contact_element.chain.py_func  # type: ignore[attr-defined]
    before = stamp(chain)
    monkeypatch.setattr(contact_element, "XV", contact_element.U)
    assert stamp(chain) != before
    others = [rod_element.strain_factor, rod_element.element_energy, rod_shape.middle]
    assert len({content_stamp(k.py_func) for k in others}) == 3  # type: ignore[attr-defined]


def test_an_inlined_kernel_runs_as_python_where_python_calls_it() -> None:
    """It has no entry for Python: a call of its machine code would end the process."""
    value, first, second = rod_element.strain_factor(0.01)
    assert value == 1.0 + 0.01 * (1.0 / 6.0 + 0.01 * (3.0 / 40.0 + 0.01 * (5.0 / 112.0)))
    assert 0.0 < second < first
