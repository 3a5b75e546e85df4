# SPDX-License-Identifier: Apache-2.0
"""The simulator's parameters: a table for each of its nodes, and the models they describe."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from spiral_gripper_ros.parameters.spec import ParameterSpec, ParameterValue, number_spec
from spiral_gripper_ros.parameters.table import number
from spiral_gripper_ros.simulation.radius_estimator import EstimatorErrors
from spiral_gripper_ros.simulation.radius_source import (
    LARGEST_VARIATION,
    ProfileSource,
    Shape,
)
from spiral_gripper_ros.simulation.regulator import Fault, RegulatorModel

NONE: Final = "none"


def _probability(name: str, text: str) -> ParameterSpec:
    return number_spec(name, 0.0, 0.0, 1.0, f"Part of the estimates that {text}.")


REGULATOR_PARAMETERS: Final[tuple[ParameterSpec, ...]] = (
    ParameterSpec(
        "gripper",
        "paper_design_70",
        "Gripper description of the simulated gripper: a shipped one's name, or a file's path.",
        read_only=True,
    ),
    ParameterSpec("frame_id", "gripper_base", "Frame of every stamped message.", read_only=True),
    number_spec(
        "stiffness_factor",
        1.0,
        0.2,
        5.0,
        "Real stiffness of the gripper's material, as a multiple of the described one.",
        read_only=True,
    ),
    number_spec(
        "object_load",
        0.0,
        0.0,
        1000.0,
        "Force that pulls at the object along gravity [N], its weight in the air; 0: none.",
    ),
    ParameterSpec(
        "fault",
        Fault.NONE.value,
        "Fault of the regulator.",
        choices=tuple(fault.value for fault in Fault),
    ),
    number_spec("time_constant", 0.1, 0.001, 10.0, "Lag of the regulator's loop [s]."),
    number_spec(
        "supply_pressure",
        3.0e5,
        1.0e4,
        1.0e6,
        "Gauge pressure of the supply [Pa]; a command above it is refused.",
        read_only=True,
    ),
    number_spec(
        "watchdog_timeout",
        0.5,
        0.02,
        60.0,
        "Silence of pressure_command after which the regulator vents by itself [s].",
    ),
    number_spec(
        "leak_time",
        0.2,
        0.01,
        100.0,
        "Time in which a leak empties a closed gripper to 1/e [s]; acts at fault leak.",
    ),
    number_spec(
        "pressure_noise", 50.0, 0.0, 1.0e5, "Standard deviation of the measured pressure [Pa]."
    ),
    number_spec(
        "pressure_resolution",
        10.0,
        0.0,
        1.0e5,
        "Step of the measured pressure [Pa]; 0: none.",
    ),
    number_spec("measured_rate", 50.0, 1.0, 100.0, "Rate of measured_pressure [Hz]."),
    number_spec("truth_rate", 20.0, 1.0, 50.0, "Rate of the topics below simulated/ [Hz]."),
    ParameterSpec(
        "shape_in_time",
        False,
        "Let simulated/backbone lag behind the pressure and swing, as a free tube with its mass "
        "does; computed in a process of its own.",
        read_only=True,
    ),
    ParameterSpec(
        "publish_clock",
        False,
        "Publish /clock, for nodes with use_sim_time; the simulation is then as fast as "
        "real_time_factor says, whatever the machine does.",
        read_only=True,
    ),
    number_spec(
        "real_time_factor", 1.0, 0.01, 10.0, "Speed of /clock; acts when publish_clock is true."
    ),
    ParameterSpec("seed", 0, "Seed of all noise.", low=0, high=1_000_000, read_only=True),
)

RADIUS_PARAMETERS: Final[tuple[ParameterSpec, ...]] = (
    ParameterSpec(
        "profile",
        Shape.CONSTANT.value,
        "The object's radius over time; none: no object, and estimates come from elsewhere.",
        choices=(*(shape.value for shape in Shape), NONE),
    ),
    number_spec(
        "radius", 0.0, 0.0, 1.0, "The object's radius [m]; 0: the middle of the gripper's range."
    ),
    number_spec(
        "radius_variation",
        0.25,
        -LARGEST_VARIATION,
        LARGEST_VARIATION,
        "Height of the step or amplitude of the sine, as a part of the radius.",
    ),
    number_spec("radius_period", 8.0, 0.01, 3600.0, "Period of step and sine [s]."),
    number_spec("estimate_rate", 20.0, 0.1, 100.0, "Estimates per second [Hz]."),
    number_spec("estimate_noise", 2.0e-5, 0.0, 0.1, "Standard deviation of the estimates [m]."),
    number_spec("estimate_bias", 0.0, -0.1, 0.1, "Bias of the estimates [m]; positive: too large."),
    _probability("outlier_probability", "are off by outlier_size"),
    number_spec("outlier_size", 0.01, 0.0, 1.0, "Size of an outlier [m]."),
    _probability("nan_probability", "are not a number"),
    _probability("dropout_probability", "do not come"),
    ParameterSpec("seed", 0, "Seed of all noise.", low=0, high=1_000_000, read_only=True),
)


def regulator_model(values: Mapping[str, ParameterValue]) -> RegulatorModel:
    """Return the regulator that checked parameter values describe."""
    return RegulatorModel(
        time_constant=number(values, "time_constant"),
        supply_pressure=number(values, "supply_pressure"),
        watchdog_timeout=number(values, "watchdog_timeout"),
        leak_time=number(values, "leak_time"),
        noise=number(values, "pressure_noise"),
        resolution=number(values, "pressure_resolution"),
    )


def radius_source(
    values: Mapping[str, ParameterValue], middle_radius: float
) -> ProfileSource | None:
    """Return the source that checked parameter values describe; None: there is no object.

    Args:
        values: of the parameters.
        middle_radius: what stands for a radius that is not given [m].
    """
    profile = str(values["profile"])
    if profile == NONE:
        return None
    return ProfileSource(
        shape=Shape(profile),
        radius=number(values, "radius") or middle_radius,
        variation=number(values, "radius_variation"),
        period=number(values, "radius_period"),
        rate=number(values, "estimate_rate"),
    )


def estimator_errors(values: Mapping[str, ParameterValue]) -> EstimatorErrors:
    """Return the errors that checked parameter values describe."""
    return EstimatorErrors(
        noise=number(values, "estimate_noise"),
        bias=number(values, "estimate_bias"),
        outlier_probability=number(values, "outlier_probability"),
        outlier_size=number(values, "outlier_size"),
        nan_probability=number(values, "nan_probability"),
        dropout_probability=number(values, "dropout_probability"),
    )
