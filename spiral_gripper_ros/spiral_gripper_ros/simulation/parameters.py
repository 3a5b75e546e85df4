# SPDX-License-Identifier: Apache-2.0
"""The simulator's parameters: a table for each of its nodes, and the models they describe."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from spiral_gripper_ros.parameters.spec import Parameters, parameter
from spiral_gripper_ros.simulation.radius_estimator import EstimatorErrors
from spiral_gripper_ros.simulation.radius_source import (
    LARGEST_VARIATION,
    ProfileSource,
    Shape,
)
from spiral_gripper_ros.simulation.regulator import Fault, RegulatorModel

NONE: Final = "none"


def _probability(text: str) -> Any:  # noqa: ANN401
    return parameter(0.0, f"Part of the estimates that {text}.", 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class SimulatedRegulatorParameters(Parameters):
    """Parameters of the simulated regulator and gripper."""

    gripper: str = parameter(
        "paper_design_70",
        "Gripper description of the simulated gripper: a shipped one's name, or a file's path.",
        read_only=True,
    )
    frame_id: str = parameter("gripper_base", "Frame of every stamped message.", read_only=True)
    stiffness_factor: float = parameter(
        1.0,
        "Real stiffness of the gripper's material, as a multiple of the described one.",
        0.2,
        5.0,
        read_only=True,
    )
    object_load: float = parameter(
        0.0,
        "Force that pulls at the object along gravity [N], its weight in the air; 0: none.",
        0.0,
        1000.0,
    )
    fault: str = parameter(
        Fault.NONE.value, "Fault of the regulator.", choices=tuple(fault.value for fault in Fault)
    )
    time_constant: float = parameter(0.1, "Lag of the regulator's loop [s].", 0.001, 10.0)
    supply_pressure: float = parameter(
        3.0e5,
        "Gauge pressure of the supply [Pa]; a command above it is refused.",
        1.0e4,
        1.0e6,
        read_only=True,
    )
    watchdog_timeout: float = parameter(
        0.5,
        "Silence of pressure_command after which the regulator vents by itself [s].",
        0.02,
        60.0,
    )
    leak_time: float = parameter(
        0.2,
        "Time in which a leak empties a closed gripper to 1/e [s]; acts at fault leak.",
        0.01,
        100.0,
    )
    pressure_noise: float = parameter(
        50.0, "Standard deviation of the measured pressure [Pa].", 0.0, 1.0e5
    )
    pressure_resolution: float = parameter(
        10.0, "Step of the measured pressure [Pa]; 0: none.", 0.0, 1.0e5
    )
    measured_rate: float = parameter(50.0, "Rate of measured_pressure [Hz].", 1.0, 100.0)
    truth_rate: float = parameter(20.0, "Rate of the topics below simulated/ [Hz].", 1.0, 50.0)
    shape_in_time: bool = parameter(
        False,
        "Let simulated/backbone lag behind the pressure and swing, as a free tube with its "
        "mass does; computed in a process of its own.",
        read_only=True,
    )
    publish_clock: bool = parameter(
        False,
        "Publish /clock, for nodes with use_sim_time; the simulation is then as fast as "
        "real_time_factor says, whatever the machine does.",
        read_only=True,
    )
    real_time_factor: float = parameter(
        1.0, "Speed of /clock; acts when publish_clock is true.", 0.01, 10.0
    )
    seed: int = parameter(0, "Seed of all noise.", 0, 1_000_000, read_only=True)


REGULATOR_PARAMETERS: Final = SimulatedRegulatorParameters.specs()


@dataclass(frozen=True, slots=True)
class RadiusParameters(Parameters):
    """Parameters of the source of radii."""

    profile: str = parameter(
        Shape.CONSTANT.value,
        "The object's radius over time; none: no object, and estimates come from elsewhere.",
        choices=(*(shape.value for shape in Shape), NONE),
    )
    radius: float = parameter(
        0.0, "The object's radius [m]; 0: the middle of the gripper's range.", 0.0, 1.0
    )
    radius_variation: float = parameter(
        0.25,
        "Height of the step or amplitude of the sine, as a part of the radius.",
        -LARGEST_VARIATION,
        LARGEST_VARIATION,
    )
    radius_period: float = parameter(8.0, "Period of step and sine [s].", 0.01, 3600.0)
    estimate_rate: float = parameter(20.0, "Estimates per second [Hz].", 0.1, 100.0)
    estimate_noise: float = parameter(2.0e-5, "Standard deviation of the estimates [m].", 0.0, 0.1)
    estimate_bias: float = parameter(
        0.0, "Bias of the estimates [m]; positive: too large.", -0.1, 0.1
    )
    outlier_probability: float = _probability("are off by outlier_size")
    outlier_size: float = parameter(0.01, "Size of an outlier [m].", 0.0, 1.0)
    nan_probability: float = _probability("are not a number")
    dropout_probability: float = _probability("do not come")
    seed: int = parameter(0, "Seed of all noise.", 0, 1_000_000, read_only=True)


RADIUS_PARAMETERS: Final = RadiusParameters.specs()


def regulator_model(values: SimulatedRegulatorParameters) -> RegulatorModel:
    """Return the regulator that checked parameter values describe."""
    return RegulatorModel(
        time_constant=values.time_constant,
        supply_pressure=values.supply_pressure,
        watchdog_timeout=values.watchdog_timeout,
        leak_time=values.leak_time,
        noise=values.pressure_noise,
        resolution=values.pressure_resolution,
    )


def radius_source(values: RadiusParameters, middle_radius: float) -> ProfileSource | None:
    """Return the source that checked parameter values describe; None: there is no object.

    Args:
        values: of the parameters.
        middle_radius: what stands for a radius that is not given [m].
    """
    profile = values.profile
    if profile == NONE:
        return None
    return ProfileSource(
        shape=Shape(profile),
        radius=values.radius or middle_radius,
        variation=values.radius_variation,
        period=values.radius_period,
        rate=values.estimate_rate,
    )


def estimator_errors(values: RadiusParameters) -> EstimatorErrors:
    """Return the errors that checked parameter values describe."""
    return EstimatorErrors(
        noise=values.estimate_noise,
        bias=values.estimate_bias,
        outlier_probability=values.outlier_probability,
        outlier_size=values.outlier_size,
        nan_probability=values.nan_probability,
        dropout_probability=values.dropout_probability,
    )
