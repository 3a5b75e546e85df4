# SPDX-License-Identifier: Apache-2.0
"""Who may import whom: dependencies run one way, and the core stays pure."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from graphlib import TopologicalSorter

import pytest
from repo.source_tree import ROOT, imports, internal_imports, modules

# Folder of spiral_core -> the folders it builds on; "" holds the errors and their validation.
CORE_FOLDERS = {
    "": set(),
    "numerics": {""},
    "actuator": {"", "numerics"},
    # One room: the mixed element and its contacts lie in a folder of their own.
    "rod": {"", "numerics", "rod.contact"},
    "rod.contact": {"", "numerics", "rod"},
    "rod.motion": {"", "numerics", "rod", "rod.contact"},
    "wrap": {"", "numerics", "actuator", "rod"},
    "grip": {"", "actuator", "rod", "rod.contact", "rod.motion", "wrap"},
    "design": {"", "numerics", "actuator", "rod", "wrap", "grip"},
    "calibration": {"", "numerics", "actuator", "rod", "rod.motion", "wrap"},
}
# The same for spiral_gripper; "" holds its public names.
EDGE_FOLDERS = {
    "": {"files", "reports", "reports.grip", "reports.closing", "bench"},
    "files": set(),
    "reports": {"files"},
    "bench": {"files", "reports"},
    "studio": {"files", "reports"},
    "cli": {"", "files", "reports", "reports.grip", "bench"},
    "reports.grip": {"files", "reports"},
    "reports.closing": {"files", "reports", "reports.grip"},
    "cli.closing": {"files", "reports", "reports.closing", "cli"},
    "cli.ros": {"files", "studio", "cli"},
}
PACKAGES = ("spiral_core", "spiral_gripper", "spiral_gripper_ros")

# The same for spiral_gripper_ros; control and planning know no ROS.
ROS_FOLDERS = {
    "": set(),
    "control": set(),
    "planning": {"control"},
    "parameters": {"control"},
    "messages": {"control", "planning"},
    "process": {"parameters"},
    "runtime": {"control", "planning", "parameters", "messages", "process"},
    "actions": {"control", "planning", "parameters", "messages", "process", "runtime"},
    "node": {"control", "planning", "parameters", "messages", "process", "runtime", "actions"},
    "regulators": {"control", "planning", "messages", "parameters", "process"},
    "simulation": {"control", "planning", "parameters", "messages", "process"},
    "client": {"control", "messages"},
    "tools": {"control", "messages", "process", "simulation", "client"},
}
WITHOUT_ROS = {"control", "planning"}
# Modules in the other folders of spiral_gripper_ros that are plain logic too.
ROS_FREE = frozenset(
    {
        "__init__", "actions.__init__", "actions.gripper_command",
        "messages.__init__",
        "node.__init__", "node.garbage", "node.proposed_gripper",
        "parameters.__init__", "parameters.spec", "parameters.table",
        "process.__init__", "process.node_process", "process.stop_signals",
        "regulators.__init__", "regulators.adapter", "regulators.command_watch",
        "regulators.device", "regulators.line_protocol", "regulators.message_field",
        "regulators.modbus_device", "regulators.parameters", "regulators.pressure_scale",
        "regulators.serial_device",
        "runtime.__init__", "runtime.event_log", "simulation.__init__",
        "simulation.pacing", "simulation.radius_estimator", "simulation.regulator",
        "simulation.simulated_gripper",
        "tools.__init__", "tools.demo_report",
    }
)  # fmt: skip

CORE_LIBRARIES = {"numba", "numpy", "scipy"}
EDGE_LIBRARIES = {
    "click", "matplotlib", "numpy", "rich", "ruamel", "trimesh", "viser",
}  # fmt: skip
# Of the modules that know no ROS; a device's library is imported when the device is used.
PLAIN_LIBRARIES = {"numpy", "rich", "serial", "spiral_core", "spiral_gripper"}
NOT_IN_THE_CORE = {
    "asyncio", "datetime", "io", "logging", "os", "pathlib", "random", "shutil", "socket",
    "subprocess", "sys", "tempfile", "threading", "time",
}  # fmt: skip
NOT_CALLED_IN_THE_CORE = {"breakpoint", "eval", "exec", "input", "open", "print"}


def tops(package: str, module: str) -> set[str]:
    """Return the top-level names that a module imports, without Python's own."""
    names = {name.split(".")[0] for name in imports(modules(package)[module])}
    return names - sys.stdlib_module_names - {package}


def folder_of(module: str) -> str:
    """Return the folder of a package in which a module lies; "" for the package's own."""
    return module.rpartition(".")[0]


def inner_imports(package: str) -> dict[str, set[str]]:
    """Return the modules of a package, and which others of it each of them imports."""
    return {
        module: internal_imports(package, path) - {"__init__"}
        for module, path in modules(package).items()
        if module != "__init__"
    }


@pytest.mark.parametrize(
    ("package", "folders"),
    [
        ("spiral_core", CORE_FOLDERS),
        ("spiral_gripper", EDGE_FOLDERS),
        ("spiral_gripper_ros", ROS_FOLDERS),
    ],
)
def test_a_folder_imports_itself_and_those_below(
    package: str, folders: dict[str, set[str]]
) -> None:
    graph = inner_imports(package)
    assert {folder_of(module) for module in graph} | {""} == folders.keys()
    upward = {
        module: beyond
        for module, imported in graph.items()
        for folder in [folder_of(module)]
        if (beyond := {one for one in imported if folder_of(one) not in folders[folder] | {folder}})
    }
    assert not upward


def test_contributing_names_every_folder() -> None:
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = re.findall(r"`([a-z_/]+)`", page)
    table = {*named, *(name.partition("/")[2] for name in named)}
    folders = {folder.replace(".", "/") for folder in CORE_FOLDERS | EDGE_FOLDERS | ROS_FOLDERS}
    assert folders - {"", "cli/ros"} <= table


@pytest.mark.parametrize("package", PACKAGES)
def test_no_import_circle(package: str) -> None:
    """Deferred imports count: a module that needs another one needs it, whenever it asks."""
    # raises CycleError and names the circle
    assert tuple(TopologicalSorter(inner_imports(package)).static_order())


@pytest.mark.parametrize("module", sorted(modules("spiral_core")))
def test_core_needs_nothing_but_numerics(module: str) -> None:
    assert tops("spiral_core", module) <= CORE_LIBRARIES


@pytest.mark.parametrize("module", sorted(modules("spiral_core")))
def test_core_touches_no_file_clock_or_screen(module: str) -> None:
    path = modules("spiral_core")[module]
    # A digest of the kernels' own source files names their cached machine code.
    allowed = {"pathlib"} if module == "numerics.kernel" else set()
    assert not {name.split(".")[0] for name in imports(path)} & NOT_IN_THE_CORE - allowed
    called = {
        node.func.id
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert not called & NOT_CALLED_IN_THE_CORE


@pytest.mark.parametrize("module", sorted(modules("spiral_gripper")))
def test_edge_knows_the_core_but_no_ros(module: str) -> None:
    assert tops("spiral_gripper", module) <= EDGE_LIBRARIES | {"spiral_core"}


def ros_free_modules() -> set[str]:
    """Return the modules of spiral_gripper_ros that know no ROS."""
    known = modules("spiral_gripper_ros")
    return {module for module in known if folder_of(module) in WITHOUT_ROS} | ROS_FREE


def test_the_modules_that_know_no_ros_exist() -> None:
    assert modules("spiral_gripper_ros").keys() >= ROS_FREE


@pytest.mark.parametrize("module", sorted(ros_free_modules()))
def test_plain_logic_of_the_node_is_free_of_ros(module: str) -> None:
    assert tops("spiral_gripper_ros", module) <= PLAIN_LIBRARIES
    inside = internal_imports("spiral_gripper_ros", modules("spiral_gripper_ros")[module])
    assert inside <= ros_free_modules()


@pytest.mark.parametrize(
    ("package", "heavy"),
    [
        ("spiral_core", {"matplotlib", "numba", "scipy"}),
        ("spiral_gripper", {"matplotlib", "numba", "rclpy", "scipy"}),
    ],
)
def test_import_is_light(package: str, heavy: set[str]) -> None:
    code = f"import sys, {package}; print(*sorted({{name.split('.')[0] for name in sys.modules}}))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(run.stdout.split())
    assert package in loaded
    assert not loaded & heavy


def names_defined(tree: ast.AST) -> set[str]:
    """Return the names that a file defines: functions, classes, attributes it assigns, slots."""
    defined = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            defined.add(node.name)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            defined.add(node.attr)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            defined.add(node.id)
    return defined


@pytest.mark.parametrize("module", sorted(modules("spiral_gripper_ros")))
def test_the_node_uses_no_private_names_of_others(module: str) -> None:
    tree = ast.parse(modules("spiral_gripper_ros")[module].read_text(encoding="utf-8"))
    private = {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute)
        and node.attr.startswith("_")
        and not node.attr.endswith("__")
    }
    assert private <= names_defined(tree)
