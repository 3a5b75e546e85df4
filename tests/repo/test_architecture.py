"""Who may import whom: dependencies run one way, and the core stays pure."""

from __future__ import annotations

import ast
import subprocess
import sys
from graphlib import TopologicalSorter
from typing import NamedTuple

import pytest
from repo.source_tree import imports, internal_imports, modules


class Layer(NamedTuple):
    """Modules of spiral_core that belong together, and the layers they build on."""

    modules: tuple[str, ...]
    below: tuple[str, ...]


# Within a layer modules may import each other, as long as no circle arises when they are loaded.
CORE_LAYERS = {
    "foundations": Layer(("errors", "kernel", "roots", "validation"), ()),
    "actuator": Layer(
        (
            "actuation", "actuator", "branch", "curvature", "fibers", "free_actuation",
            "materials", "measured_actuation", "pressure", "tube", "volume", "winding",
        ),
        ("foundations",),
    ),
    "helix": Layer(("helix",), ("foundations",)),
    "rod": Layer(
        (
            "rod", "rod_algebra", "rod_batch", "rod_batch_kernel", "rod_discretization",
            "rod_element", "rod_equilibria", "rod_follow", "rod_newton", "rod_path", "rod_shape",
            "rod_statics", "rod_uniform",
        ),
        ("foundations",),
    ),
    "coil": Layer(("coil", "coil_kernels"), ("foundations", "rod")),
    "gripper": Layer(
        (
            "gripper", "wrap", "wrap_branch", "wrap_curve", "wrap_kernel", "wrap_table",
        ),
        ("foundations", "actuator", "helix", "rod", "coil"),
    ),
    "design": Layer(
        (
            "charts", "design", "design_evaluation", "design_exact", "design_helix",
            "design_margin", "design_nearest", "design_report", "design_requirement",
            "design_steps", "design_sweep", "object_profile",
        ),
        ("foundations", "actuator", "helix", "rod", "gripper"),
    ),
    "calibration": Layer(
        (
            "calibration_choice", "calibration_fit", "calibration_identifiability",
            "calibration_model", "calibration_neighbor", "calibration_observations",
            "calibration_plausibility", "calibration_prediction", "calibration_profile",
            "calibration_result", "calibration_solver", "calibration_start",
            "calibration_uncertainty", "grip_drift", "measured_curve",
        ),
        ("foundations", "actuator", "rod", "coil", "gripper"),
    ),
}  # fmt: skip

# Folders of spiral_gripper_ros that a test can run without ROS, and what they build on.
WITHOUT_ROS = {"control": {"control"}, "planning": {"control", "planning"}}
# The other folders, and the modules in them that are plain logic too.
WITH_ROS = {"client", "demo", "doctor", "grasping", "node", "simulation", "smoke"}
ROS_FREE = frozenset(
    {
        "__init__", "demo.__init__", "demo.report", "demo.table", "doctor.__init__",
        "doctor.checks", "doctor.domain", "doctor.environment", "doctor.interfaces",
        "doctor.memory", "doctor.security", "grasping.__init__", "grasping.goal_jobs",
        "grasping.gripper_command", "node.__init__", "node.grip_log", "node.parameters",
        "node.proposed_gripper", "node.quiet_memory", "node.stop_signals", "node.usage",
        "node_process",
        "simulation.__init__", "simulation.pacing", "simulation.parameters",
        "simulation.radius_estimator", "simulation.radius_source", "simulation.regulator",
        "simulation.replay", "simulation.simulated_gripper", "simulation.simulator_usage",
        "simulation.valve", "simulation.view", "smoke.__init__", "smoke.verdict",
    }
)  # fmt: skip

CORE_LIBRARIES = {"numba", "numpy", "scipy"}
EDGE_LIBRARIES = {"click", "matplotlib", "numpy", "pint", "rich", "ruamel"}
NOT_IN_THE_CORE = {
    "asyncio", "datetime", "io", "logging", "os", "pathlib", "random", "shutil", "socket",
    "subprocess", "sys", "tempfile", "threading", "time",
}  # fmt: skip
NOT_CALLED_IN_THE_CORE = {"breakpoint", "eval", "exec", "input", "open", "print"}


def tops(package: str, module: str) -> set[str]:
    """Return the top-level names that a module imports, without Python's own."""
    names = {name.split(".")[0] for name in imports(modules(package)[module])}
    return names - sys.stdlib_module_names - {package}


def core_imports(module: str, *, deferred: bool = True) -> set[str]:
    """Return the other modules of spiral_core that one of them imports."""
    path = modules("spiral_core")[module]
    return internal_imports("spiral_core", path, deferred=deferred)


def test_every_core_module_has_exactly_one_layer() -> None:
    listed = [module for layer in CORE_LAYERS.values() for module in layer.modules]
    assert sorted(listed) == sorted(modules("spiral_core").keys() - {"__init__"})


def test_core_layers_build_on_earlier_ones() -> None:
    earlier: set[str] = set()
    for name, layer in CORE_LAYERS.items():
        assert set(layer.below) <= earlier
        earlier.add(name)


@pytest.mark.parametrize("layer", CORE_LAYERS)
def test_core_imports_its_own_layer_and_those_below(layer: str) -> None:
    allowed = {m for name in (layer, *CORE_LAYERS[layer].below) for m in CORE_LAYERS[name].modules}
    upward = {
        module: beyond
        for module in CORE_LAYERS[layer].modules
        if (beyond := core_imports(module) - allowed)
    }
    assert not upward


def test_core_has_no_import_circle() -> None:
    graph = {
        module: core_imports(module, deferred=False)
        for module in modules("spiral_core").keys() - {"__init__"}
    }
    assert tuple(TopologicalSorter(graph).static_order())  # raises CycleError and names the circle


@pytest.mark.parametrize("module", sorted(modules("spiral_core")))
def test_core_needs_nothing_but_numerics(module: str) -> None:
    assert tops("spiral_core", module) <= CORE_LIBRARIES


@pytest.mark.parametrize("module", sorted(modules("spiral_core")))
def test_core_touches_no_file_clock_or_screen(module: str) -> None:
    path = modules("spiral_core")[module]
    assert not {name.split(".")[0] for name in imports(path)} & NOT_IN_THE_CORE
    called = {
        node.func.id
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert not called & NOT_CALLED_IN_THE_CORE


@pytest.mark.parametrize("module", sorted(modules("spiral_gripper")))
def test_edge_knows_the_core_but_no_ros(module: str) -> None:
    assert tops("spiral_gripper", module) <= EDGE_LIBRARIES | {"spiral_core"}


def folder_of(module: str) -> str:
    """Return the folder of spiral_gripper_ros in which a module lies; "" for the package's own."""
    return module.rpartition(".")[0]


def ros_free_modules() -> set[str]:
    """Return the modules of spiral_gripper_ros that know no ROS."""
    known = modules("spiral_gripper_ros")
    return {module for module in known if folder_of(module) in WITHOUT_ROS} | ROS_FREE


def test_every_ros_module_has_a_folder() -> None:
    folders = {folder_of(module) for module in modules("spiral_gripper_ros")}
    assert folders == {"", *WITHOUT_ROS, *WITH_ROS}
    assert modules("spiral_gripper_ros").keys() >= ROS_FREE


@pytest.mark.parametrize("module", sorted(ros_free_modules()))
def test_plain_logic_of_the_node_is_free_of_ros(module: str) -> None:
    assert tops("spiral_gripper_ros", module) <= {"numpy", "rich", "spiral_core", "spiral_gripper"}
    inside = internal_imports("spiral_gripper_ros", modules("spiral_gripper_ros")[module])
    assert inside <= ros_free_modules()
    below = WITHOUT_ROS.get(folder_of(module))
    assert below is None or {folder_of(one) for one in inside} <= below


@pytest.mark.parametrize(
    ("package", "heavy"),
    [
        ("spiral_core", {"matplotlib", "numba", "pint", "scipy"}),
        ("spiral_gripper", {"matplotlib", "numba", "rclpy", "scipy"}),
    ],
)
def test_import_is_light(package: str, heavy: set[str]) -> None:
    code = f"import sys, {package}; print(*sorted({{name.split('.')[0] for name in sys.modules}}))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(run.stdout.split())
    assert package in loaded
    assert not loaded & heavy
