# SPDX-License-Identifier: Apache-2.0
"""Everything that may come to the control logic: the usual, the odd and the impossible."""

from hypothesis import strategies as st

from spiral_core import InvalidInputError, SolverError, WrapRegime
from spiral_core.rod.state import RodStatus
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import AbortPolicy, FaultPolicy, Limits, TimeoutPolicy

VENTS = ["release", "activate", "deactivate", "fail"]
ANY_FLOAT = st.floats(allow_nan=True, allow_infinity=True)
FINITE = st.floats(allow_nan=False, allow_infinity=False)
GOOD_RADIUS = st.one_of(st.sampled_from([0.02, 0.021, 0.03]), st.floats(0.012, 0.04))
RADIUS = st.one_of(GOOD_RADIUS, GOOD_RADIUS, st.floats(0.0, 0.06), ANY_FLOAT)
PRESSURE = st.one_of(st.floats(-2.0e5, 2.0e5), ANY_FLOAT)
PLANNER_ERRORS = (
    *[None] * 6,
    SolverError(RodStatus.UNSTABLE, 1.0, 7),
    InvalidInputError("radius", 0.0, "another one"),
    ZeroDivisionError("a planner with a bug"),
)
LIMITS = st.builds(
    Limits,
    pressure_cap=st.one_of(st.just(9.0e4), st.floats(1.0e3, 2.0e5)),
    pressure_rate_up=st.one_of(st.just(1.0e5), st.floats(1.0e2, 1.0e7)),
    pressure_rate_down=st.one_of(st.just(2.0e5), st.floats(1.0e2, 1.0e7)),
    radius_timeout=st.floats(0.01, 5.0),
    radius_timeout_policy=st.sampled_from(TimeoutPolicy),
    radius_rate_limit=st.floats(1.0e-4, 10.0),
    radius_jump_limit=st.floats(1.0e-5, 1.0),
    radius_hysteresis=st.floats(0.0, 0.1),
    grasp_timeout=st.floats(0.1, 10.0),
    grasp_abort_policy=st.sampled_from(AbortPolicy),
    measured_pressure_timeout=st.floats(0.01, 5.0),
    pressure_settle_time=st.one_of(st.floats(0.0, 1.0), st.floats(0.0, 60.0)),
    pressure_tolerance=st.one_of(st.just(1.0e3), st.floats(10.0, 1.0e6)),
    pressure_fault_policy=st.sampled_from(FaultPolicy),
    grip_ratio=st.sampled_from([None, 1.0, 1.2]),
)
USUAL_LIMITS = st.builds(
    Limits,
    pressure_cap=st.sampled_from([9.0e4, 4.0e4]),
    radius_timeout=st.sampled_from([0.1, 1.0]),
    radius_timeout_policy=st.sampled_from(TimeoutPolicy),
    grasp_timeout=st.sampled_from([10.0, 0.6]),
    grasp_abort_policy=st.sampled_from(AbortPolicy),
    pressure_fault_policy=st.sampled_from(FaultPolicy),
    grip_ratio=st.sampled_from([None, 1.0]),
)
GOOD_GOALS = st.builds(
    GraspGoal,
    radius=st.one_of(st.none(), GOOD_RADIUS),
    overpressure=st.sampled_from([None, 0.0, 2.0e3]),
    abort_policy=st.sampled_from([None, *AbortPolicy]),
)
ANY_GOALS = st.builds(
    GraspGoal,
    radius=st.one_of(st.none(), RADIUS),
    overpressure=st.one_of(st.none(), st.floats(0.0, 2.0e4), ANY_FLOAT),
    timeout=st.one_of(st.none(), st.floats(0.05, 5.0), ANY_FLOAT),
    abort_policy=st.sampled_from([None, *AbortPolicy]),
)
LEAPS = st.one_of(st.sampled_from([0.0, 1.0e-9, 0.5, 60.0, 1.0e6, -1.0e-9, -5.0, -1.0e6]), FINITE)
PERIODS = st.sampled_from([0.0, 0.002, 0.02, 0.02, 0.1, 1.0])
EYES = st.sampled_from([None, *WrapRegime])
