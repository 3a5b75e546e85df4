# SPDX-License-Identifier: Apache-2.0
"""`spiral-gripper studio --ros` follows a real node with a simulated regulator, in Chromium."""

import os
import signal

import numpy as np
import pytest
from browser import PATIENCE, appears, opened, studio, wait_until
from ros.programs import PROGRAM, line_with, rest_of, start
from ros.records import agrees

from spiral_gripper.studio.live import NodeState, live_text
from spiral_gripper_msgs.msg import Grip


def test_what_is_said_of_a_node_is_that_on_record():
    forces = {"holding_force_away": 0.22, "holding_force_towards": 0.31}
    held = Grip(contact_length=0.1, normal_force=1.5, **forces)
    scene = np.zeros((2, 3)), 0.005, None
    state = NodeState(
        0.0, "tracking", 5.0e4, 5.7e4, 5.1e4, 0.02, "overhang", held, ("<i> > 1",), *scene
    )
    agrees("live", live_text(state))


@pytest.mark.slow
@pytest.mark.timeout(4 * PATIENCE)
def test_the_page_follows_a_node_until_it_is_silent(simulation, namespace):
    with (
        studio("--ros", "--namespace", namespace, "--units", "psi,mm") as address,
        opened(address) as page,
    ):
        appears(page, r"measured [\d.]+ psi")
        picture = page.locator("canvas").first.screenshot()
        appears(page, "perfect wrap")
        wait_until(lambda: 19.0 < float(appears(page, "object radius").split()[2]) < 21.0)
        wait_until(lambda: page.locator("canvas").first.screenshot() != picture)
        page.screenshot(path=os.environ.get("STUDIO_LIVE_SCREENSHOT"))
        simulation.send_signal(signal.SIGINT)
        appears(page, r"The node is silent\. What follows is \d+ s old")


def test_without_a_node_the_page_waits(namespace):
    with start(PROGRAM, "studio", "--ros", "--namespace", namespace, "--no-browser") as page:
        said = line_with(page, "Ctrl-C")
        assert said.startswith(f"studio of the node in {namespace}: http://")
        assert rest_of(page, signal.SIGINT)[0] == 0
