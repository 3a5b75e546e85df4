"""Mechanics of pneumatic spiral grippers: pure functions on immutable values, SI units.

Every public name can be imported from here. What needs compiled kernels is loaded when it is first
used, so that ``import spiral_core`` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from spiral_core.actuator.actuator import Actuator, CurvatureForm
from spiral_core.actuator.curvature import rest_shape_from_stretch
from spiral_core.actuator.fibers import FiberAngles, FiberState, fiber_state, locking_stretch
from spiral_core.actuator.free import FreeActuation
from spiral_core.actuator.interface import ActuationModel, RestShape
from spiral_core.actuator.materials import (
    Gent,
    HyperelasticLaw,
    InvariantDerivatives,
    MooneyRivlin,
    NeoHookean,
    Yeoh,
)
from spiral_core.actuator.pressure import energy_from_stretch, pressure_from_stretch
from spiral_core.actuator.tube import Tube
from spiral_core.errors import (
    ActuationLimit,
    ActuationLimitError,
    InvalidInputError,
    NoCoilError,
    NotGrippableError,
    SolverError,
    SpiralError,
)
from spiral_core.wrap.helix import Helix, helix_from_curvature, helix_orientations, helix_positions

if TYPE_CHECKING:
    from spiral_core.actuator.measured import MeasuredActuation
    from spiral_core.actuator.winding import Winding, windings_of
    from spiral_core.calibration.fit import calibrate
    from spiral_core.calibration.grip_drift import (
        DriftKind,
        DriftSuggestion,
        GripRecord,
        suggest_drift_correction,
    )
    from spiral_core.calibration.identifiability import WeakDirection, weak_directions
    from spiral_core.calibration.intervals import profile_interval
    from spiral_core.calibration.measured_curve import measured_actuation_from_readings
    from spiral_core.calibration.model import CalibrationModel, FittedQuantity
    from spiral_core.calibration.readings import (
        BendReading,
        ExtensionReading,
        GripReading,
        Reading,
        ShapeReading,
        TwistReading,
    )
    from spiral_core.calibration.result import Calibration, Interval
    from spiral_core.calibration.selection import (
        CrossValidation,
        LawChoice,
        choose_law,
        leave_one_out,
    )
    from spiral_core.calibration.uncertainty import (
        RadiusPressure,
        pressure_uncertainty,
        pressure_uncertainty_by_draws,
    )
    from spiral_core.design.charts import (
        DesignSpace,
        PressureRange,
        RegimeChart,
        design_space,
        helix_range,
        pressure_range,
        regime_chart,
        without_gravity,
    )
    from spiral_core.design.helix_estimate import GripFigures
    from spiral_core.design.margin import Constraint, Margin
    from spiral_core.design.procedure import design_gripper
    from spiral_core.design.report import Design, DesignReport, DesignStep, Figure, Relaxation
    from spiral_core.design.requirement import (
        Candidate,
        DesignRequirement,
        Elastomer,
        Preference,
        TubeSize,
    )
    from spiral_core.design.sweep import (
        FeasibilityMap,
        SweepPoint,
        feasibility_map,
        pareto_set,
        solve_points,
    )
    from spiral_core.rod.batch import RodBatch, solve_rods
    from spiral_core.rod.equilibria import find_equilibria
    from spiral_core.rod.path import Fold, RodPath, follow_path
    from spiral_core.rod.solve import solve_rod
    from spiral_core.rod.types import Rod, RodLoad, RodState, RodStatus, RodStiffness
    from spiral_core.wrap.coil import Coil, coil_axis, coil_from_state
    from spiral_core.wrap.curve import WrapCurve
    from spiral_core.wrap.gripper import Gripper, gripper_from_actuator, stiffness_from_actuator
    from spiral_core.wrap.profile import ObjectProfile, ProfileWrap, Station, wrap_for_profile
    from spiral_core.wrap.wrap import Wrap, WrapRegime, line_force

_MODULE_OF_LAZY_NAME = {
    "BendReading": "calibration.readings",
    "Calibration": "calibration.result",
    "CalibrationModel": "calibration.model",
    "Candidate": "design.requirement",
    "Coil": "wrap.coil",
    "Constraint": "design.margin",
    "CrossValidation": "calibration.selection",
    "Design": "design.report",
    "DesignReport": "design.report",
    "DesignRequirement": "design.requirement",
    "DesignSpace": "design.charts",
    "DesignStep": "design.report",
    "DriftKind": "calibration.grip_drift",
    "DriftSuggestion": "calibration.grip_drift",
    "Elastomer": "design.requirement",
    "ExtensionReading": "calibration.readings",
    "FeasibilityMap": "design.sweep",
    "Figure": "design.report",
    "FittedQuantity": "calibration.model",
    "Fold": "rod.path",
    "GripFigures": "design.helix_estimate",
    "GripReading": "calibration.readings",
    "GripRecord": "calibration.grip_drift",
    "Gripper": "wrap.gripper",
    "Interval": "calibration.result",
    "LawChoice": "calibration.selection",
    "Margin": "design.margin",
    "MeasuredActuation": "actuator.measured",
    "ObjectProfile": "wrap.profile",
    "Preference": "design.requirement",
    "PressureRange": "design.charts",
    "ProfileWrap": "wrap.profile",
    "RadiusPressure": "calibration.uncertainty",
    "Reading": "calibration.readings",
    "RegimeChart": "design.charts",
    "Relaxation": "design.report",
    "Rod": "rod.types",
    "RodBatch": "rod.batch",
    "RodLoad": "rod.types",
    "RodPath": "rod.path",
    "RodState": "rod.types",
    "RodStatus": "rod.types",
    "RodStiffness": "rod.types",
    "ShapeReading": "calibration.readings",
    "Station": "wrap.profile",
    "SweepPoint": "design.sweep",
    "TubeSize": "design.requirement",
    "TwistReading": "calibration.readings",
    "WeakDirection": "calibration.identifiability",
    "Winding": "actuator.winding",
    "Wrap": "wrap.wrap",
    "WrapCurve": "wrap.curve",
    "WrapRegime": "wrap.wrap",
    "calibrate": "calibration.fit",
    "choose_law": "calibration.selection",
    "coil_axis": "wrap.coil",
    "coil_from_state": "wrap.coil",
    "design_gripper": "design.procedure",
    "design_space": "design.charts",
    "feasibility_map": "design.sweep",
    "find_equilibria": "rod.equilibria",
    "follow_path": "rod.path",
    "gripper_from_actuator": "wrap.gripper",
    "helix_range": "design.charts",
    "leave_one_out": "calibration.selection",
    "measured_actuation_from_readings": "calibration.measured_curve",
    "line_force": "wrap.wrap",
    "pareto_set": "design.sweep",
    "pressure_range": "design.charts",
    "pressure_uncertainty": "calibration.uncertainty",
    "pressure_uncertainty_by_draws": "calibration.uncertainty",
    "profile_interval": "calibration.intervals",
    "regime_chart": "design.charts",
    "solve_points": "design.sweep",
    "solve_rod": "rod.solve",
    "solve_rods": "rod.batch",
    "stiffness_from_actuator": "wrap.gripper",
    "suggest_drift_correction": "calibration.grip_drift",
    "weak_directions": "calibration.identifiability",
    "windings_of": "actuator.winding",
    "without_gravity": "design.charts",
    "wrap_for_profile": "wrap.profile",
}

__all__ = [
    "ActuationLimit",
    "ActuationLimitError",
    "ActuationModel",
    "Actuator",
    "BendReading",
    "Calibration",
    "CalibrationModel",
    "Candidate",
    "Coil",
    "Constraint",
    "CrossValidation",
    "CurvatureForm",
    "Design",
    "DesignReport",
    "DesignRequirement",
    "DesignSpace",
    "DesignStep",
    "DriftKind",
    "DriftSuggestion",
    "Elastomer",
    "ExtensionReading",
    "FeasibilityMap",
    "FiberAngles",
    "FiberState",
    "Figure",
    "FittedQuantity",
    "Fold",
    "FreeActuation",
    "Gent",
    "GripFigures",
    "GripReading",
    "GripRecord",
    "Gripper",
    "Helix",
    "HyperelasticLaw",
    "Interval",
    "InvalidInputError",
    "InvariantDerivatives",
    "LawChoice",
    "Margin",
    "MeasuredActuation",
    "MooneyRivlin",
    "NeoHookean",
    "NoCoilError",
    "NotGrippableError",
    "ObjectProfile",
    "Preference",
    "PressureRange",
    "ProfileWrap",
    "RadiusPressure",
    "Reading",
    "RegimeChart",
    "Relaxation",
    "RestShape",
    "Rod",
    "RodBatch",
    "RodLoad",
    "RodPath",
    "RodState",
    "RodStatus",
    "RodStiffness",
    "ShapeReading",
    "SolverError",
    "SpiralError",
    "Station",
    "SweepPoint",
    "Tube",
    "TubeSize",
    "TwistReading",
    "WeakDirection",
    "Winding",
    "Wrap",
    "WrapCurve",
    "WrapRegime",
    "Yeoh",
    "calibrate",
    "choose_law",
    "coil_axis",
    "coil_from_state",
    "design_gripper",
    "design_space",
    "energy_from_stretch",
    "feasibility_map",
    "fiber_state",
    "find_equilibria",
    "follow_path",
    "gripper_from_actuator",
    "helix_from_curvature",
    "helix_orientations",
    "helix_positions",
    "helix_range",
    "leave_one_out",
    "line_force",
    "locking_stretch",
    "measured_actuation_from_readings",
    "pareto_set",
    "pressure_from_stretch",
    "pressure_range",
    "pressure_uncertainty",
    "pressure_uncertainty_by_draws",
    "profile_interval",
    "regime_chart",
    "rest_shape_from_stretch",
    "solve_points",
    "solve_rod",
    "solve_rods",
    "stiffness_from_actuator",
    "suggest_drift_correction",
    "weak_directions",
    "windings_of",
    "without_gravity",
    "wrap_for_profile",
]


def __getattr__(name: str) -> object:
    """Load a public name that needs compiled kernels, on first use."""
    if name not in _MODULE_OF_LAZY_NAME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{_MODULE_OF_LAZY_NAME[name]}"), name)
    globals()[name] = value  # the next use finds it at once
    return value
