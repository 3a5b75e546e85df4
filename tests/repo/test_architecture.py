# SPDX-License-Identifier: Apache-2.0
"""Who may import whom: dependencies run one way, and the core stays pure."""

import ast
import re
import subprocess
import sys
from graphlib import TopologicalSorter

import pytest
from core.recorded import recorded
from repo.source_tree import PYTHON_PACKAGES, foreign, imports, internal_imports, modules

ROS = re.compile("rclpy|_msgs|_srvs|_interfaces|tf2")
NOT_IN_THE_CORE = {
    "asyncio", "datetime", "io", "logging", "os", "pathlib", "random", "shutil", "socket",
    "subprocess", "sys", "tempfile", "threading", "time",
}  # fmt: skip
NOT_CALLED_IN_THE_CORE = {"breakpoint", "eval", "exec", "input", "open", "print"}
every_package = pytest.mark.parametrize("package", PYTHON_PACKAGES)


def folder_of(module):
    """Return the folder of a package in which a module lies; "" for the package's own."""
    return module.rpartition(".")[0]


@every_package
def test_what_each_folder_imports_is_recorded_and_never_in_a_circle(package):
    """Deferred imports count: a module that needs another one needs it, whenever it asks.

    Of the node's modules those that know ROS are recorded, and what libraries all others use; none
    of control and planning knows ROS.
    """
    known = modules(package)
    graph = {module: internal_imports(package, path) for module, path in known.items()}
    libraries = {module: foreign(package, path) for module, path in known.items()}
    found = {folder_of(module): set() for module in known}
    for module, imported in graph.items():
        found[folder_of(module)] |= {folder_of(one) or "." for one in imported - {"__init__"}}
    plain = {module for module in graph if not ROS.search(" ".join(libraries[module]))}
    while not all(graph[module] <= plain for module in plain):
        plain = {module for module in plain if graph[module] <= plain}
    used = set().union(*(libraries[module] for module in plain))
    found |= {"with ROS": graph.keys() - plain, "libraries": used}
    recorded(f"architecture/{package}", {k: " ".join(sorted(v - {k})) for k, v in found.items()})
    assert {module for module in graph if folder_of(module) in ("control", "planning")} <= plain
    del graph["__init__"]
    for imported in graph.values():
        imported.discard("__init__")
    TopologicalSorter(graph).prepare()  # raises CycleError and names the circle


def test_the_core_touches_no_file_clock_or_screen():
    for module, path in modules("spiral_core").items():
        # A digest of the kernels' own source files names their cached machine code.
        allowed = {"pathlib"} if module == "numerics.kernel" else set()
        tops = {name.partition(".")[0] for name in imports(path)}
        assert not tops & NOT_IN_THE_CORE - allowed, module
        nodes = ast.walk(ast.parse(path.read_text("utf-8")))
        calls = {getattr(node.func, "id", "") for node in nodes if isinstance(node, ast.Call)}
        assert not calls & NOT_CALLED_IN_THE_CORE, module


@pytest.mark.parametrize("package", PYTHON_PACKAGES[:2])
def test_import_is_light(package):
    code = f"import sys, {package}; print(*{{name.split('.')[0] for name in sys.modules}})"
    loaded = subprocess.check_output([sys.executable, "-c", code], text=True).split()
    assert package in loaded
    assert not {*loaded} & {"matplotlib", "numba", "rclpy", "scipy"}
