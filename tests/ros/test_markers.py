# SPDX-License-Identifier: Apache-2.0
"""What RViz draws: the geometry of the messages, and that they come and go on a real node."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ros.harness import all_finite, tick
from ros.local_nodes import change, state_of
from ros.records import agrees, told
from std_msgs.msg import Header

from spiral_core.wrap.placement import place_object
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.conversions import vector_from_msg
from spiral_gripper_ros.messages.markers import (
    REGIME_COLORS,
    scene_to_msg,
)
from spiral_gripper_ros.tools.studio import StudioListener

OUTER = 0.00555


@pytest.fixture(scope="module")
def wrap(planner):
    return planner.plan(0.02).wrap


def drawn(commanded=None, measured=None, placement=None):
    scene = commanded, measured, placement, None, "TRACKING", OUTER
    message = scene_to_msg(*scene, points=10_000, lifetime=1.25, header=Header())
    assert all_finite(message)
    return {marker.ns: marker for marker in message.markers}


def test_the_colors_of_the_regimes_are_those_on_record(wrap):
    placement = place_object(wrap)
    scenes = [(None, None, placement, regime, "", OUTER) for regime in REGIME_COLORS]
    named = {"points": 2, "lifetime": 1.25, "header": Header()}
    agrees("scenes", "".join(told(scene_to_msg(*one, **named)) for one in scenes))


def points_of(marker):
    return np.array([vector_from_msg(point) for point in marker.points])


# A nearly opposite axis is drawn exactly opposite.
@pytest.mark.parametrize("axis", [(2 / 3, -1 / 3, -2 / 3), (1e-9, 0, -1)])
def test_tube_fiber_and_object_lie_where_they_are(wrap, planner, axis):
    state, (other, _) = wrap.state, planner.shape(0.5 * wrap.pressure, None)
    placement = replace(place_object(wrap), axis=axis)
    alone, both = drawn(state, None, placement), drawn(state, other)
    assert points_of(both["measured_tube"]) == pytest.approx(other.positions)
    # The fiber is on the gripper as it is, outside, towards the object.
    assert points_of(both["straight_fiber"])[-1] == pytest.approx(other.positions[-1], abs=OUTER)
    offsets = points_of(alone["straight_fiber"]) - state.positions
    assert np.linalg.norm(offsets, axis=1) == pytest.approx(OUTER)
    assert np.abs(np.sum(offsets * state.tangents, axis=1)).max() < 1e-12
    assert offsets[-1] @ (np.array(placement.center) - state.positions[-1]) > 0.0
    # The studio hears the scene that was sent.
    sent = {"status": GripStatus(), "markers": SimpleNamespace(markers=alone.values())}
    heard = StudioListener.heard(SimpleNamespace(newest=sent.get, received_at=lambda _: 0.0))
    seen = heard.placement
    assert (heard.outer_radius, seen.radius) == pytest.approx((OUTER, wrap.object_radius))
    assert (*seen.center, *seen.axis) == pytest.approx((*placement.center, *axis), abs=1e-8)
    assert heard.tube == pytest.approx(state.positions)


# --- a node in this process --------------------------------------------------------------------


@pytest.mark.parametrize("rate", [0.0, 5e-324, 50.0])
def test_no_rate_of_the_markers_lets_go(node, rate):
    before, told = len(list(node.timers)), {}
    node.runtime.outputs.publish = told.__setitem__
    change(node, publish__marker_rate=rate, publish__rate=200.0)
    assert 5_000_000 in [timer.timer_period_ns for timer in node.timers]
    assert (len(list(node.timers)) == before) == (rate > 0.0)
    tick(node)
    assert ("status" in told, "markers" in told) == (True, False)
    assert (node.runtime.errors.count, state_of(node)[0]) == (0, State.WAITING)
