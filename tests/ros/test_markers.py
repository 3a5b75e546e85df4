# SPDX-License-Identifier: Apache-2.0
"""What RViz draws: the geometry of the messages, and that they come and go on a real node."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from rclpy.parameter import Parameter
from ros.harness import all_finite, deliver, tick
from std_msgs.msg import Float64, Header
from visualization_msgs.msg import Marker

from spiral_core import WrapRegime
from spiral_core.wrap.placement import ObjectPlacement, place_object
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.markers import (
    NAMESPACES,
    REGIME_COLORS,
    Scene,
    no_markers,
    scene_to_msg,
)
from spiral_gripper_ros.planning.object_pose import object_line
from spiral_gripper_ros.tools.studio import StudioListener

OUTER = 0.00555
ALWAYS = {"tube", "straight_fiber", "state"}


@pytest.fixture(scope="module")
def wrap(planner):
    return planner.plan(0.02).wrap


def drawn(points=50, **parts):
    nothing = dict.fromkeys(("commanded", "measured", "placement", "regime"))
    scene = Scene(**{**nothing, "text": "", "outer_radius": OUTER, **parts})
    message = scene_to_msg(scene, points, 1.25, Header(frame_id="base"))
    assert all_finite(message)
    return {marker.ns: marker for marker in message.markers}


def points_of(marker):
    return np.array([(p.x, p.y, p.z) for p in marker.points])


def test_the_studio_hears_the_scene_that_was_sent(wrap):
    markers = drawn(commanded=wrap.state, placement=place_object(wrap))
    sent = {"status": GripStatus(), "markers": SimpleNamespace(markers=markers.values())}
    heard = StudioListener.heard(SimpleNamespace(newest=sent.get, received_at=lambda _: 0.0))
    assert heard.outer_radius == pytest.approx(OUTER)
    assert heard.placement.radius == pytest.approx(wrap.object_radius)
    assert heard.tube == pytest.approx(points_of(markers["tube"]))


def test_every_message_adds_what_there_is_and_deletes_what_there_is_not(wrap):
    markers = drawn(7, commanded=wrap.state, text="TRACKING")
    assert tuple(markers) == NAMESPACES
    for ns, marker in markers.items():
        assert marker.action == (Marker.ADD if ns in ALWAYS else Marker.DELETE)
        assert (marker.id, marker.header.frame_id) == (0, "base")
    gone = no_markers(Header()).markers
    assert [(m.ns, m.action) for m in gone] == [(ns, Marker.DELETE) for ns in NAMESPACES]
    lifetime = markers["state"].lifetime  # then a display forgets those of a node that is gone
    assert (lifetime.sec, lifetime.nanosec, markers["state"].text) == (1, 250_000_000, "TRACKING")
    tube = markers["tube"]
    assert (tube.type, tube.scale.x, tube.frame_locked) == (Marker.LINE_STRIP, 2.0 * OUTER, True)
    assert len(tube.points) == 7
    assert points_of(tube)[[0, -1]] == pytest.approx(wrap.state.positions[[0, -1]])


def test_a_measured_tube_has_a_color_of_its_own_and_fades_the_commanded_one(wrap, planner):
    other = planner.shape(0.5 * wrap.pressure, None).state
    both = drawn(commanded=wrap.state, measured=other)
    assert both["tube"].color.a < 1.0 == drawn(commanded=wrap.state)["tube"].color.a
    assert both["measured_tube"].color != both["tube"].color
    assert points_of(both["measured_tube"])[-1] == pytest.approx(other.positions[-1])
    # The fiber is on the gripper as it is.
    assert points_of(both["straight_fiber"])[-1] == pytest.approx(other.positions[-1], abs=OUTER)


def test_the_fiber_runs_on_the_outside_of_the_tube_towards_the_object(wrap):
    state = wrap.state
    offsets = points_of(drawn(10_000, commanded=state)["straight_fiber"]) - state.positions
    assert np.linalg.norm(offsets, axis=1) == pytest.approx(OUTER)
    assert np.abs(np.sum(offsets * state.tangents, axis=1)).max() < 1e-12
    assert offsets[-1] @ (np.array(place_object(wrap).center) - state.positions[-1]) > 0.0


# A nearly opposite axis is drawn exactly opposite.
@pytest.mark.parametrize("axis", [(0, 0, 1), (2 / 3, -1 / 3, -2 / 3), (1e-9, 0, -1)])
def test_the_cylinder_lies_along_the_axis(axis):
    placement = ObjectPlacement((0.1, -0.2, 0.3), axis, 0.02, 0.07, 0.0)
    cylinder = drawn(placement=placement)["object"]
    q, at, scale = cylinder.pose.orientation, cylinder.pose.position, cylinder.scale
    seen = object_line((at.x, at.y, at.z), (q.x, q.y, q.z, q.w))
    assert seen == (placement.center, pytest.approx(axis, abs=1e-8))
    assert (cylinder.type, scale.x, scale.y, scale.z) == (Marker.CYLINDER, 0.04, 0.04, 0.07)


# --- a node in this process --------------------------------------------------------------------


def test_what_there_is_is_drawn_and_goes_again(node, told, gripper):
    def shown():
        tick(node)
        added = {m.ns: m for m in told["markers"].markers if m.action == Marker.ADD}
        return set(added), added

    names, added = shown()
    assert names == {*ALWAYS, "object"}
    assert added["object"].color.g == pytest.approx(REGIME_COLORS[WrapRegime.PERFECT_WRAP][1])
    assert added["tube"].header.frame_id == "gripper_base"
    assert added["tube"].scale.x == pytest.approx(2.0 * gripper.tube.outer_radius)
    deliver(node, "measured_pressure", Float64(data=node.published[-1]))
    node.runtime.control.release()
    names, added = shown()
    assert names == {*ALWAYS, "measured_tube"}
    assert re.match(r"RELEASED  0.0 kPa\nmeasured  57.\d kPa", added["state"].text)
    node.trigger_deactivate()
    assert {marker.action for marker in told["markers"].markers} == {Marker.DELETE}


@pytest.mark.parametrize("rate", [0.0, 5e-324, 50.0])
def test_no_rate_of_the_markers_lets_go(node, rate):
    before = len(list(node.timers))
    (result,) = node.set_parameters([Parameter("publish.marker_rate", value=rate)])
    assert result.successful
    assert (len(list(node.timers)) == before) == (rate > 0.0)
    assert (node.runtime.errors.count, node.runtime.control.snapshot().state) == (0, State.WAITING)


def test_nothing_is_drawn_while_nobody_looks(node):
    told = []
    node.runtime.outputs.publish = lambda name, message: told.append(name)
    tick(node)
    assert "status" in told
    assert "markers" not in told


def test_rate_and_points_act_at_once(node, told):
    values = {"publish.rate": 200.0, "publish.backbone_points": 7}
    node.set_parameters([Parameter(name, value=value) for name, value in values.items()])
    assert 5_000_000 in [timer.timer_period_ns for timer in node.timers]
    tick(node)
    (tube,) = (marker for marker in told["markers"].markers if marker.ns == "tube")
    assert len(tube.points) == 7
