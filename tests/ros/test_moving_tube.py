# SPDX-License-Identifier: Apache-2.0
"""The simulator's shape in time: the rod's motion from question to question, and as published."""

import queue
import threading

import numpy as np
import pytest
from ros.simulation_harness import QUIET, RADIUS, Observer, RunningSimulator, seconds

from spiral_core import SpiralError, inertia_of, solve_motion
from spiral_core.grip.setup import FREE_ELEMENTS, free_problem
from spiral_gripper import load_gripper
from spiral_gripper_ros.simulation.moving_tube import MovingTube, SteppedTube, TubeQuestion
from spiral_gripper_ros.simulation.pacing import LONGEST_STEP
from spiral_gripper_ros.simulation.simulated_gripper import SimulatedGripper

PRESSURE, RISE = 4.0e4, 0.2


def test_answers_are_the_motion_of_the_free_tube(gripper):
    times = [0.0, 0.05, 0.2, 0.3, 0.5]
    tube = SteppedTube()
    shapes = [
        tube.answer(TubeQuestion(gripper, t, PRESSURE * min(t / RISE, 1.0))).positions
        for t in times
    ]
    motion = solve_motion(
        lambda t: free_problem(gripper, PRESSURE * min(t / RISE, 1.0)),
        inertia_of(gripper),
        times,
        elements=FREE_ELEMENTS,
    )
    np.testing.assert_allclose(shapes, motion.positions, atol=1e-9)


@pytest.mark.parametrize("period", [0.05, 1.0])
@pytest.mark.parametrize("calls", [1, 7, 40])
def test_a_tube_that_takes_long_to_compute_moves_more_slowly_and_skips_nothing(
    gripper, period, calls
):
    """An answer takes so many calls: the steps of the tube's own time stay as short as usual."""
    questions, answered = queue.Queue(), threading.Semaphore(0)

    def ask(question):
        questions.put(question)
        answered.acquire()

    tube, now, times = MovingTube(gripper, ask), 0.0, []
    for _ in range(10):
        for _ in range(calls):
            tube.follow(now, PRESSURE)
            now += period
        assert tube.is_computing
        times.append(questions.get(timeout=60.0).time)
        answered.release()
        while tube.is_computing:
            pass
    tube.end()
    longest = max(LONGEST_STEP, period)
    np.testing.assert_allclose(np.diff(times), min(calls * period, longest), atol=1e-9)


def test_a_pressure_that_cannot_be_is_no_shape_and_the_next_one_is(gripper):
    tube = SteppedTube()
    tube.answer(TubeQuestion(gripper, 0.0, 0.0))
    with pytest.raises(SpiralError):
        tube.answer(TubeQuestion(gripper, 0.1, 1e7))
    tube.answer(TubeQuestion(gripper, 0.2, 0.0))


def test_a_process_that_has_ended_is_no_shape(gripper):
    tube = MovingTube(gripper)
    tube.end()
    tube._pool.shutdown(wait=True)
    with pytest.raises(RuntimeError):
        tube.follow(0.0, 0.0)


def test_the_published_shape_lags_behind_and_swings():
    namespace = "/moving_tube"
    observer = Observer(namespace)
    parameters = {
        **QUIET, "radius": RADIUS, "shape_in_time": "true", "time_constant": 0.01,
        "publish_clock": "true", "watchdog_timeout": 60.0,
    }  # fmt: skip
    still = SimulatedGripper(load_gripper("paper_design_70"))
    first, last = (still.shape(p).tip_position for p in (0.0, PRESSURE))
    way = np.subtract(last, first)

    def along(tip):
        """Return how far along its way at rest the tip is."""
        return np.subtract(tip, first) @ way / (way @ way)

    def swings_beyond():
        """Command a pressure that jumps every two seconds of simulated time, and look."""
        heard, observer.shapes[:] = list(observer.shapes), []
        if heard:
            times.append(seconds(heard[-1].header.stamp))
            observer.command(PRESSURE if times[-1] % 4.0 < 2.0 else 0.0)
        tips = [shape.poses[-1].position for shape in heard]
        return any(along((tip.x, tip.y, tip.z)) > 1.2 for tip in tips)

    times = []
    assert max(along(still.shape(p).tip_position) for p in np.linspace(0.0, PRESSURE, 21)) < 1.01
    with RunningSimulator(namespace, parameters) as simulator:
        observer.wait_for_simulator()
        observer.wait_until(swings_beyond, "the tube to swing beyond where it rests")
        assert times[-1] - times[0] < 8.0  # simulated, however slow the machine is
        assert simulator.stop() == 0, simulator.log()
        assert "Traceback" not in simulator.log()
    observer.close()
