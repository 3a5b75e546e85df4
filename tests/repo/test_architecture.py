# SPDX-License-Identifier: Apache-2.0
"""Who may import whom: dependencies run one way, and the core stays pure."""

import ast
import subprocess
import sys
from graphlib import TopologicalSorter

import pytest
from repo.source_tree import PYTHON_PACKAGES, foreign, imports, internal_imports, modules

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
    "grip": {"", "numerics", "actuator", "rod", "rod.contact", "rod.motion", "wrap"},
    "design": {"", "numerics", "actuator", "rod", "wrap", "grip"},
    "calibration": {"", "numerics", "actuator", "rod", "rod.motion", "wrap", "grip"},
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
# The same for spiral_gripper_ros; control and planning know no ROS.
LOW = {"control", "planning", "parameters", "messages", "process"}
ROS_FOLDERS = {
    "": set(),
    "control": set(),
    "planning": {"control"},
    "parameters": {"control"},
    "messages": {"control", "planning"},
    "process": {"parameters"},
    "runtime": LOW,
    "actions": LOW | {"runtime"},
    "node": LOW | {"runtime", "actions"},
    "regulators": LOW,
    "simulation": LOW,
    "client": {"control", "messages"},
    "tools": {"control", "messages", "process", "simulation", "client"},
}
WITHOUT_ROS = {"control", "planning"}
# Modules in the other folders of spiral_gripper_ros that are plain logic too.
ROS_FREE = frozenset(
    {
        "__init__", "actions.__init__", "actions.gripper_command",
        "messages.__init__",
        "node.__init__",
        "parameters.__init__", "parameters.spec", "parameters.table",
        "process.__init__", "process.node_process", "process.stop_signals",
        "regulators.__init__", "regulators.adapter", "regulators.command_watch",
        "regulators.device", "regulators.line_protocol", "regulators.message_field",
        "regulators.modbus_device", "regulators.parameters", "regulators.pressure_scale",
        "regulators.serial_device",
        "runtime.__init__", "runtime.event_log", "simulation.__init__",
        "simulation.pacing", "simulation.radius_estimator", "simulation.regulator",
        "simulation.simulated_gripper",
        "tools.__init__",
    }
)  # fmt: skip

FOLDERS = dict(zip(PYTHON_PACKAGES, (CORE_FOLDERS, EDGE_FOLDERS, ROS_FOLDERS), strict=True))
LIBRARIES = {
    "spiral_core": {"numba", "numpy", "scipy"},
    "spiral_gripper": {
        "click", "matplotlib", "numpy", "rich", "ruamel", "spiral_core", "trimesh", "viser",
    },
    # Of the modules that know no ROS; a device's library is imported when the device is used.
    "spiral_gripper_ros": {"numpy", "rich", "serial", "spiral_core", "spiral_gripper"},
}  # fmt: skip
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
def test_a_folder_imports_itself_and_those_below_and_never_in_a_circle(package):
    """Deferred imports count: a module that needs another one needs it, whenever it asks."""
    graph = {module: internal_imports(package, path) for module, path in modules(package).items()}
    del graph["__init__"]
    folders = FOLDERS[package]
    assert {folder_of(module) for module in graph} | {""} == folders.keys()
    for module, imported in graph.items():
        imported.discard("__init__")
        own = folder_of(module)
        assert {folder_of(one) for one in imported} <= folders[own] | {own}, module
    TopologicalSorter(graph).prepare()  # raises CycleError and names the circle


@every_package
def test_a_package_knows_its_own_libraries_and_only_the_node_ros(package):
    known = modules(package)
    plain = known.keys()
    if package == "spiral_gripper_ros":
        plain = {module for module in known if folder_of(module) in WITHOUT_ROS} | ROS_FREE
    for module in plain:
        assert foreign(package, known[module]) <= LIBRARIES[package], module
        assert internal_imports(package, known[module]) <= plain, module


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
