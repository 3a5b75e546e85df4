# SPDX-License-Identifier: Apache-2.0
"""What RViz draws: the geometry of the messages, and that they come and go on a real node."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from rclpy.parameter import Parameter
from ros.harness import all_finite, deliver
from std_msgs.msg import Float64, Header
from visualization_msgs.msg import Marker, MarkerArray

from spiral_core import WrapRegime
from spiral_core.wrap.placement import ObjectPlacement, place_object
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.markers import (
    NAMESPACES,
    REGIME_COLORS,
    Scene,
    no_markers,
    scene_to_msg,
)
from spiral_gripper_ros.planning.planner import GripperPlanner

OUTER = 0.00555


@pytest.fixture(scope="module")
def wrap(gripper):
    return GripperPlanner(gripper).plan(0.02).wrap


def scene(**parts):
    nothing = {
        "commanded": None,
        "measured": None,
        "placement": None,
        "regime": None,
        "text": "",
        "outer_radius": OUTER,
    }
    return Scene(**{**nothing, **parts})


def drawn(of, points=50, lifetime=1.0):
    message = scene_to_msg(of, points, lifetime, Header(frame_id="base"))
    assert all_finite(message)
    return {marker.ns: marker for marker in message.markers}


def points_of(marker):
    return np.array([(p.x, p.y, p.z) for p in marker.points])


def rotated_z(q):
    return (
        2.0 * (q.x * q.z + q.w * q.y),
        2.0 * (q.y * q.z - q.w * q.x),
        1.0 - 2.0 * (q.x * q.x + q.y * q.y),
    )


def test_every_message_adds_what_there_is_and_deletes_what_there_is_not(wrap):
    markers = drawn(scene(commanded=wrap.state))
    assert tuple(markers) == NAMESPACES
    actions = {ns: marker.action for ns, marker in markers.items()}
    added = [ns for ns, action in actions.items() if action == Marker.ADD]
    assert added == ["tube", "straight_fiber"]
    assert all(actions[ns] == Marker.DELETE for ns in NAMESPACES if ns not in added)
    assert {marker.id for marker in markers.values()} == {0}
    assert {marker.header.frame_id for marker in markers.values()} == {"base"}
    assert {m.action for m in no_markers(Header()).markers} == {Marker.DELETE}
    assert tuple(m.ns for m in no_markers(Header()).markers) == NAMESPACES


def test_the_tube_is_a_line_of_its_diameter_along_the_backbone(wrap):
    tube = drawn(scene(commanded=wrap.state), points=7)["tube"]
    assert tube.type == Marker.LINE_STRIP
    assert tube.scale.x == 2.0 * OUTER
    assert len(tube.points) == 7
    ends = wrap.state.positions[[0, -1]]
    assert points_of(tube)[[0, -1]] == pytest.approx(ends)
    assert tube.frame_locked
    assert tube.pose.orientation.w == 1.0


def test_a_measured_tube_has_a_color_of_its_own_and_fades_the_commanded_one(wrap, gripper):
    planner = GripperPlanner(gripper)
    other = planner.shape(0.5 * wrap.pressure, None).state
    alone = drawn(scene(commanded=wrap.state))["tube"]
    both = drawn(scene(commanded=wrap.state, measured=other))
    assert alone.color.a == 1.0
    assert both["tube"].color.a < 1.0
    assert both["measured_tube"].color != both["tube"].color
    assert points_of(both["measured_tube"])[-1] == pytest.approx(other.positions[-1])
    # The fiber is on the gripper as it is.
    assert points_of(both["straight_fiber"])[-1] == pytest.approx(other.positions[-1], abs=OUTER)


def test_the_fiber_runs_on_the_outside_of_the_tube_towards_the_object(wrap):
    placement = place_object(wrap)
    fiber = points_of(drawn(scene(commanded=wrap.state), points=10_000)["straight_fiber"])
    offsets = fiber - wrap.state.positions
    assert np.linalg.norm(offsets, axis=1) == pytest.approx(OUTER)
    assert np.abs(np.sum(offsets * wrap.state.tangents, axis=1)).max() < 1e-12
    tip_to_object = np.array(placement.center) - wrap.state.positions[-1]
    assert offsets[-1] @ tip_to_object > 0.0


@pytest.mark.parametrize(
    "axis",
    [
        (0.0, 0.0, 1.0),
        (0.0, 0.0, -1.0),
        (1.0, 0.0, 0.0),
        (0.0, -1.0, 0.0),
        (2.0 / 3.0, -1.0 / 3.0, -2.0 / 3.0),
        (1e-9, 0.0, -1.0),
    ],
)
def test_the_cylinder_lies_along_the_axis(axis):
    placement = ObjectPlacement((0.1, -0.2, 0.3), axis, 0.02, 0.07, 0.0)
    cylinder = drawn(scene(placement=placement))["object"]
    assert cylinder.type == Marker.CYLINDER
    q = cylinder.pose.orientation
    assert math.hypot(q.x, q.y, q.z, q.w) == pytest.approx(1.0)
    # A nearly opposite axis is drawn exactly opposite.
    assert rotated_z(q) == pytest.approx(axis, abs=1e-8)
    at = cylinder.pose.position
    assert (at.x, at.y, at.z) == placement.center
    assert (cylinder.scale.x, cylinder.scale.y, cylinder.scale.z) == (0.04, 0.04, 0.07)


def test_the_object_shows_by_its_color_how_it_is_held():
    placement = ObjectPlacement((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.02, 0.07, 0.0)
    colors = {
        regime: drawn(scene(placement=placement, regime=regime))["object"].color
        for regime in (None, *WrapRegime)
    }
    assert set(REGIME_COLORS) == set(colors)
    assert len({(c.r, c.g, c.b) for c in colors.values()}) == len(colors)


def test_a_display_forgets_the_markers_of_a_node_that_is_gone(wrap):
    marker = drawn(scene(commanded=wrap.state, text="TRACKING"), lifetime=1.25)["state"]
    assert marker.text == "TRACKING"
    assert (marker.lifetime.sec, marker.lifetime.nanosec) == (1, 250_000_000)


class Display:
    """A stand-in for RViz: keeps what is drawn, by the rules of its messages."""

    def __init__(self, client):
        self.client = client
        self.messages, self.shown = [], {}
        self._subscription = client.create_subscription(MarkerArray, "markers", self._on, 10)

    def _on(self, message):
        self.messages.append(message)
        for marker in message.markers:
            if marker.action == Marker.ADD:
                self.shown[marker.ns] = marker
            else:
                self.shown.pop(marker.ns, None)

    def wait_for(self, *namespaces):
        self.client.wait_until(
            lambda: self.messages and set(self.shown) == set(namespaces), f"{namespaces} only"
        )

    def close(self):
        self.client.destroy_subscription(self._subscription)


@pytest.fixture
def display(active):
    display = Display(active)
    yield display
    display.close()


def test_the_object_appears_with_its_wrap_and_goes_with_it(active, display, gripper):
    display.wait_for("tube", "straight_fiber", "state")
    status = active.wrap(0.02)
    display.wait_for("tube", "straight_fiber", "state", "object")
    green = REGIME_COLORS[WrapRegime.PERFECT_WRAP]
    active.wait_until(
        lambda: display.shown["object"].color.g == pytest.approx(green[1]), "the perfect wrap"
    )
    assert display.shown["object"].scale.x == pytest.approx(0.04)
    assert display.shown["tube"].header.frame_id == "gripper_base"
    assert display.shown["tube"].header.stamp.sec > 0
    assert display.shown["tube"].scale.x == pytest.approx(2.0 * gripper.tube.outer_radius)
    at = active.backbones[-1].poses[-1].position
    active.wait_until(
        lambda: points_of(display.shown["tube"])[-1] == pytest.approx((at.x, at.y, at.z), abs=1e-9),
        "its tip",
    )
    assert "TRACKING" in display.shown["state"].text
    assert f"{1e-3 * status.pressure_command:.1f} kPa" in display.shown["state"].text
    assert active.release().success
    display.wait_for("tube", "straight_fiber", "state")
    assert "RELEASED" in display.shown["state"].text
    assert all_finite(*display.messages)


def test_the_measured_tube_is_drawn_while_it_is_measured(active, display):
    assert active.set_parameter("measured_pressure.timeout", 0.3).successful
    active.regulator = lambda pressure: pressure
    display.wait_for("tube", "measured_tube", "straight_fiber", "state")
    assert "measured" in display.shown["state"].text
    active.regulator = None
    display.wait_for("tube", "straight_fiber", "state")
    assert "PRESSURE_LOST" in display.shown["state"].text


def test_deactivation_deletes_every_marker(active, display):
    display.wait_for("tube", "straight_fiber", "state")
    assert active.transition("deactivate")
    display.wait_for()


def test_markers_come_at_their_rate_and_not_at_all_at_zero(active, display):
    assert active.set_parameter("publish.marker_rate", 50.0).successful
    display.messages.clear()
    active.wait_until(lambda: len(display.messages) > 5, "markers")
    assert active.set_parameter("publish.marker_rate", 0.0).successful
    display.wait_for()
    display.messages.clear()
    active.spin(0.3)
    assert display.messages == []


@pytest.mark.parametrize("rate", [5.0, 50.0])
def test_markers_are_drawn_at_the_rate_of_the_parameter(node, rate):
    assert node.set_parameters([Parameter("publish.marker_rate", value=rate)])[0].successful
    drawing = [timer for timer in node.timers if timer.callback == node._display.draw]
    assert [timer.timer_period_ns for timer in drawing] == [1e9 / rate]


def test_nothing_is_drawn_while_nobody_looks(node):
    drawn_for_nobody = []
    node.runtime.outputs.publish = lambda *drawn: drawn_for_nobody.append(drawn)
    node._display.draw()
    assert drawn_for_nobody == []


def test_an_exception_while_drawing_is_logged_and_does_not_vent(node, capfd):
    deliver(node, "object_radius", Float64(data=0.02))
    good, node.runtime.outputs = node.runtime.outputs, SimpleNamespace(markers_are_wanted=True)
    node._display.draw()
    node.runtime.outputs = good
    assert node.runtime.control.snapshot().state is State.TRACKING
    assert node.runtime.errors.count == 1
    assert "AttributeError" in capfd.readouterr().err
