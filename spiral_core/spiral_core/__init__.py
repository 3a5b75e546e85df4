# SPDX-License-Identifier: Apache-2.0
"""Mechanics of pneumatic spiral grippers: pure functions on immutable values, SI units.

Every public name can be imported from here and is loaded when it is first used, so that
``import spiral_core`` stays light. Names are added to :data:`_NAMES` and to ``__init__.pyi``, which
type checkers read.
"""

from importlib import import_module

_NAMES = {
    "actuator.actuator": ("Actuator", "CurvatureForm", "PressureLaw"),
    "actuator.curvature": ("unloaded_shape_from_stretch",),
    "actuator.fibers": ("FiberAngles", "FiberState", "OneFamily", "fiber_state", "locking_stretch"),
    "actuator.free": ("FreeActuation",),
    "actuator.interface": ("ActuationModel", "UnloadedShape"),
    "actuator.materials": (
        "Gent",
        "HyperelasticLaw",
        "InvariantDerivatives",
        "MooneyRivlin",
        "NeoHookean",
        "Yeoh",
    ),
    "actuator.measured": ("MeasuredActuation",),
    "actuator.pressure": ("energy_from_stretch", "pressure_from_stretch"),
    "actuator.single_fiber": ("SingleFiber",),
    "actuator.tube": ("Tube",),
    "actuator.winding": ("Winding", "windings_of"),
    "calibration.fit": ("calibrate",),
    "calibration.identifiability": ("WeakDirection", "weak_directions"),
    "calibration.intervals": ("profile_interval",),
    "calibration.measured_curve": ("measured_actuation_from_readings",),
    "calibration.model": ("CalibrationModel", "FittedQuantity"),
    "calibration.readings": (
        "BendReading",
        "ExtensionReading",
        "GripReading",
        "Reading",
        "ShapeReading",
        "TwistReading",
    ),
    "calibration.result": ("Calibration", "Interval"),
    "calibration.selection": ("CrossValidation", "LawChoice", "choose_law", "leave_one_out"),
    "calibration.swing": ("SwingFit", "SwingReading", "fit_swing"),
    "calibration.uncertainty": (
        "RadiusPressure",
        "pressure_uncertainty",
        "pressure_uncertainty_by_draws",
    ),
    "closing.close": (
        "RateAdvice",
        "TimedClosing",
        "advise_rate",
        "close_on",
        "closing_frames",
        "enclosed_volume",
        "inertia_of",
        "slow_closing",
    ),
    "closing.course": ("PressureCourse",),
    "closing.pneumatics": ("Orifice", "Supply", "orifices_in_series"),
    "closing.settling": ("settling_after_move", "settling_after_ramp", "vibrations"),
    "design.charts": (
        "DesignSpace",
        "PressureRange",
        "RegimeChart",
        "design_space",
        "helix_range",
        "pressure_range",
        "regime_chart",
        "without_gravity",
    ),
    "design.helix_estimate": ("GripFigures",),
    "design.margin": ("Constraint", "Margin"),
    "design.procedure": ("design_gripper",),
    "design.report": ("Design", "DesignReport", "DesignStep", "StepQuantity", "Relaxation"),
    "design.requirement": ("Candidate", "DesignRequirement", "Elastomer", "Preference", "TubeSize"),
    "design.sweep": (
        "FeasibilityMap",
        "SweepPoint",
        "feasibility_map",
        "pareto_set",
        "solve_points",
    ),
    "errors": (
        "ActuationLimit",
        "ActuationLimitError",
        "InvalidInputError",
        "NoCoilError",
        "NotGrippableError",
        "SolverError",
        "SpiralError",
    ),
    "grip.grip": ("Grip", "RangeEnd", "solve_grip"),
    "grip.holding": ("HoldingForce", "Pull", "PullEnd", "holding_force", "holding_forces"),
    "grip.mount": ("Mount", "MountAim", "misplacements", "place_mount", "search_mount"),
    "grip.point": ("GripPoint",),
    "grip.setup": ("Closing", "GripSetup", "lay_into_coil", "lay_profile_into_coil"),
    "grip.study": ("GripCase", "GripOutcome", "grip_cases", "solve_case", "solve_cases"),
    "grip.window": ("GripWindow", "WindowEnd", "follow_loss", "grip_window"),
    "rod.batch": ("RodBatch", "solve_rods"),
    "rod.contact.obstacles": ("Obstacle",),
    "rod.contact.problem": (
        "Clamped",
        "ContactProblem",
        "ElasticRod",
        "Free",
        "Guided",
        "Pinned",
        "PointLoad",
        "Section",
    ),
    "rod.contact.shapes": (
        "Capsule",
        "Cone",
        "Cylinder",
        "Plane",
        "Profile",
        "SignedDistance",
        "Sphere",
    ),
    "rod.contact.solve": (
        "follow_contact",
        "solve_contact",
    ),
    "rod.contact.state": (
        "ContactEvent",
        "ContactPath",
        "ContactState",
        "ContactStatus",
        "SelfContact",
    ),
    "rod.equilibria": ("find_equilibria",),
    "rod.motion.frequencies": ("Modes", "vibration_modes"),
    "rod.motion.inertia": ("UNDAMPED", "Damping", "Inertia"),
    "rod.motion.motion": (
        "EventKind",
        "Frame",
        "Motion",
        "MotionEvent",
        "MotionStatus",
        "contact_fraction",
    ),
    "rod.motion.solve": ("motion_frames", "solve_motion"),
    "rod.motion.swing": ("Swing",),
    "rod.path": ("Fold", "RodPath", "follow_path"),
    "rod.solve": ("solve_rod",),
    "rod.types": ("Rod", "RodCertificate", "RodLoad", "RodState", "RodStatus", "RodStiffness"),
    "wrap.coil": ("Coil", "coil_axis", "coil_from_state"),
    "wrap.curve": ("WrapCurve",),
    "wrap.gripper": (
        "Gripper",
        "gripper_from_actuator",
        "stiffness_from_actuator",
        "stiffness_from_section",
    ),
    "wrap.helix": ("Helix", "helix_from_curvature", "helix_orientations", "helix_positions"),
    "wrap.placement": ("ObjectPlacement", "place_object"),
    "wrap.profile": ("ObjectProfile", "ProfileWrap", "Station", "wrap_for_profile"),
    "wrap.wrap": ("Wrap", "WrapRegime", "line_force"),
}
_MODULE_OF_NAME = {name: module for module, names in _NAMES.items() for name in names}

__all__ = sorted(_MODULE_OF_NAME)  # noqa: PLE0605 - computed, so that no name is stated twice


def __getattr__(name: str) -> object:
    """Load the module that holds a public name when the name is first used."""
    module = _MODULE_OF_NAME.get(name)
    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{module}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return list(__all__)
