# SPDX-License-Identifier: Apache-2.0
"""What RViz draws: the geometry of the messages, and that they come and go on a real node."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ros.harness import all_finite, deliver, tick
from ros.local_nodes import change, state_of
from std_msgs.msg import Float64, Header
from visualization_msgs.msg import Marker

from spiral_core import WrapRegime
from spiral_core.wrap.placement import place_object
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.markers import (
    NAMESPACES,
    REGIME_COLORS,
    Scene,
    scene_to_msg,
)
from spiral_gripper_ros.tools.studio import StudioListener

OUTER = 0.00555
ALWAYS = {"tube", "straight_fiber", "state"}


@pytest.fixture(scope="module")
def wrap(planner):
    return planner.plan(0.02).wrap


def drawn(commanded=None, measured=None, placement=None):
    scene = Scene(commanded, measured, placement, None, "TRACKING", OUTER)
    message = scene_to_msg(scene, 10_000, 1.25, Header())
    assert all_finite(message)
    return {marker.ns: marker for marker in message.markers}


def points_of(marker):
    return np.array([(p.x, p.y, p.z) for p in marker.points])


def test_every_message_adds_what_there_is_and_deletes_what_there_is_not(wrap):
    markers = drawn(wrap.state)
    assert tuple(markers) == NAMESPACES
    assert {ns for ns, marker in markers.items() if marker.action == Marker.ADD} == ALWAYS
    tube, text = markers["tube"], markers["state"]
    lifetime = text.lifetime  # then a display forgets those of a node that is gone
    assert (lifetime.sec, lifetime.nanosec, text.text) == (1, 250_000_000, "TRACKING")
    assert (tube.type, tube.scale.x, tube.frame_locked) == (Marker.LINE_STRIP, 2.0 * OUTER, True)


# A nearly opposite axis is drawn exactly opposite.
@pytest.mark.parametrize("axis", [(2 / 3, -1 / 3, -2 / 3), (1e-9, 0, -1)])
def test_tube_fiber_and_object_lie_where_they_are(wrap, planner, axis):
    state, other = wrap.state, planner.shape(0.5 * wrap.pressure, None).state
    placement = replace(place_object(wrap), axis=axis)
    alone, both = drawn(state, None, placement), drawn(state, other)
    # A measured tube has a color of its own and fades the commanded one.
    assert both["tube"].color.a < 1.0 == alone["tube"].color.a
    assert both["measured_tube"].color != both["tube"].color
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


def test_what_there_is_is_drawn_as_the_parameters_say_and_goes_again(node, told, gripper):
    def shown():
        tick(node)
        return {m.ns: m for m in told["markers"].markers if m.action == Marker.ADD}

    change(node, publish__rate=200.0, publish__backbone_points=7)
    assert 5_000_000 in [timer.timer_period_ns for timer in node.timers]
    added = shown()
    assert added.keys() == {*ALWAYS, "object"}
    assert added["object"].color.g == pytest.approx(REGIME_COLORS[WrapRegime.PERFECT_WRAP][1])
    tube = added["tube"]
    assert (tube.header.frame_id, len(tube.points)) == ("gripper_base", 7)
    assert tube.scale.x == pytest.approx(2.0 * gripper.tube.outer_radius)
    deliver(node, "measured_pressure", Float64(data=node.published[-1]))
    node.runtime.control.release()
    added = shown()
    assert added.keys() == {*ALWAYS, "measured_tube"}
    assert re.match(r"RELEASED  0.0 kPa\nmeasured  57.\d kPa", added["state"].text)
    node.trigger_deactivate()
    gone = [(marker.ns, marker.action) for marker in told["markers"].markers]
    assert gone == [(ns, Marker.DELETE) for ns in NAMESPACES]


@pytest.mark.parametrize("rate", [0.0, 5e-324, 50.0])
def test_no_rate_of_the_markers_lets_go(node, rate):
    before, told = len(list(node.timers)), {}
    node.runtime.outputs.publish = told.__setitem__
    change(node, publish__marker_rate=rate)
    assert (len(list(node.timers)) == before) == (rate > 0.0)
    tick(node)
    assert ("status" in told, "markers" in told) == (True, False)
    assert (node.runtime.errors.count, state_of(node)[0]) == (0, State.WAITING)
