"""Mechanics of pneumatic spiral grippers: pure functions on immutable values, SI units.

Every public name can be imported from here. What needs compiled kernels is loaded when it is first
used, so that ``import spiral_core`` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from spiral_core.actuation import ActuationModel, RestShape
from spiral_core.actuator import Actuator, CurvatureForm
from spiral_core.curvature import rest_shape_from_stretch
from spiral_core.errors import (
    ActuationLimit,
    ActuationLimitError,
    InvalidInputError,
    NoCoilError,
    NotGrippableError,
    SolverError,
    SpiralError,
)
from spiral_core.fibers import FiberAngles, FiberState, fiber_state, locking_stretch
from spiral_core.free_actuation import FreeActuation
from spiral_core.helix import Helix, helix_from_curvature, helix_orientations, helix_positions
from spiral_core.materials import (
    Gent,
    HyperelasticLaw,
    InvariantDerivatives,
    MooneyRivlin,
    NeoHookean,
    Yeoh,
)
from spiral_core.pressure import energy_from_stretch, pressure_from_stretch
from spiral_core.tube import Tube

if TYPE_CHECKING:
    from spiral_core.calibration_choice import CrossValidation, LawChoice, choose_law, leave_one_out
    from spiral_core.calibration_fit import calibrate
    from spiral_core.calibration_identifiability import WeakDirection, weak_directions
    from spiral_core.calibration_model import CalibrationModel, FittedQuantity
    from spiral_core.calibration_observations import (
        BendReading,
        ExtensionReading,
        GripReading,
        Reading,
        ShapeReading,
        TwistReading,
    )
    from spiral_core.calibration_profile import profile_interval
    from spiral_core.calibration_result import Calibration, Interval
    from spiral_core.calibration_uncertainty import (
        RadiusPressure,
        pressure_uncertainty,
        pressure_uncertainty_by_draws,
    )
    from spiral_core.charts import (
        DesignSpace,
        PressureRange,
        RegimeChart,
        design_space,
        helix_range,
        pressure_range,
        regime_chart,
        without_gravity,
    )
    from spiral_core.coil import Coil, coil_axis, coil_from_state
    from spiral_core.design import design_gripper
    from spiral_core.design_helix import GripFigures
    from spiral_core.design_margin import Constraint, Margin
    from spiral_core.design_report import Design, DesignReport, DesignStep, Figure, Relaxation
    from spiral_core.design_requirement import (
        Candidate,
        DesignRequirement,
        Elastomer,
        Preference,
        TubeSize,
    )
    from spiral_core.design_sweep import (
        FeasibilityMap,
        SweepPoint,
        feasibility_map,
        pareto_set,
        solve_points,
    )
    from spiral_core.grip_drift import (
        DriftKind,
        DriftSuggestion,
        GripRecord,
        suggest_drift_correction,
    )
    from spiral_core.gripper import Gripper, gripper_from_actuator, stiffness_from_actuator
    from spiral_core.measured_actuation import MeasuredActuation
    from spiral_core.measured_curve import measured_actuation_from_readings
    from spiral_core.object_profile import ObjectProfile, ProfileWrap, Station, wrap_for_profile
    from spiral_core.rod import Rod, RodLoad, RodState, RodStatus, RodStiffness, solve_rod
    from spiral_core.rod_batch import RodBatch, solve_rods
    from spiral_core.rod_equilibria import find_equilibria
    from spiral_core.rod_path import Fold, RodPath, follow_path
    from spiral_core.winding import Winding, windings_of
    from spiral_core.wrap import Wrap, WrapRegime, line_force
    from spiral_core.wrap_curve import WrapCurve

_MODULE_OF_LAZY_NAME = {
    "BendReading": "calibration_observations",
    "Calibration": "calibration_result",
    "CalibrationModel": "calibration_model",
    "Candidate": "design_requirement",
    "Coil": "coil",
    "Constraint": "design_margin",
    "CrossValidation": "calibration_choice",
    "Design": "design_report",
    "DesignReport": "design_report",
    "DesignRequirement": "design_requirement",
    "DesignSpace": "charts",
    "DesignStep": "design_report",
    "DriftKind": "grip_drift",
    "DriftSuggestion": "grip_drift",
    "Elastomer": "design_requirement",
    "ExtensionReading": "calibration_observations",
    "FeasibilityMap": "design_sweep",
    "Figure": "design_report",
    "FittedQuantity": "calibration_model",
    "Fold": "rod_path",
    "GripFigures": "design_helix",
    "GripReading": "calibration_observations",
    "GripRecord": "grip_drift",
    "Gripper": "gripper",
    "Interval": "calibration_result",
    "LawChoice": "calibration_choice",
    "Margin": "design_margin",
    "MeasuredActuation": "measured_actuation",
    "ObjectProfile": "object_profile",
    "Preference": "design_requirement",
    "PressureRange": "charts",
    "ProfileWrap": "object_profile",
    "RadiusPressure": "calibration_uncertainty",
    "Reading": "calibration_observations",
    "RegimeChart": "charts",
    "Relaxation": "design_report",
    "Rod": "rod",
    "RodBatch": "rod_batch",
    "RodLoad": "rod",
    "RodPath": "rod_path",
    "RodState": "rod",
    "RodStatus": "rod",
    "RodStiffness": "rod",
    "ShapeReading": "calibration_observations",
    "Station": "object_profile",
    "SweepPoint": "design_sweep",
    "TubeSize": "design_requirement",
    "TwistReading": "calibration_observations",
    "WeakDirection": "calibration_identifiability",
    "Winding": "winding",
    "Wrap": "wrap",
    "WrapCurve": "wrap_curve",
    "WrapRegime": "wrap",
    "calibrate": "calibration_fit",
    "choose_law": "calibration_choice",
    "coil_axis": "coil",
    "coil_from_state": "coil",
    "design_gripper": "design",
    "design_space": "charts",
    "feasibility_map": "design_sweep",
    "find_equilibria": "rod_equilibria",
    "follow_path": "rod_path",
    "gripper_from_actuator": "gripper",
    "helix_range": "charts",
    "leave_one_out": "calibration_choice",
    "measured_actuation_from_readings": "measured_curve",
    "line_force": "wrap",
    "pareto_set": "design_sweep",
    "pressure_range": "charts",
    "pressure_uncertainty": "calibration_uncertainty",
    "pressure_uncertainty_by_draws": "calibration_uncertainty",
    "profile_interval": "calibration_profile",
    "regime_chart": "charts",
    "solve_points": "design_sweep",
    "solve_rod": "rod",
    "solve_rods": "rod_batch",
    "stiffness_from_actuator": "gripper",
    "suggest_drift_correction": "grip_drift",
    "weak_directions": "calibration_identifiability",
    "windings_of": "winding",
    "without_gravity": "charts",
    "wrap_for_profile": "object_profile",
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
