# SPDX-License-Identifier: Apache-2.0
"""`spiral-gripper studio --ros` follows a real node with a simulated regulator, in Chromium."""

import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from browser import PATIENCE, appears, opened, studio, wait_until

from spiral_gripper.studio.live import HoldingFigures, NodeState, live_text

HEARD = NodeState(
    age=0.0,
    state="tracking",
    command=5.0e4,
    target=5.7e4,
    measured=None,
    object_radius=None,
    regime="overhang",
    held=None,
    troubles=("it leaks",),
    tube=np.zeros((2, 3)),
    outer_radius=0.005,
    placement=None,
)


def test_what_holds_is_said_with_its_direction():
    held = HoldingFigures(contact_length=0.1, normal_force=1.5, away=0.22, towards=0.31)
    text = live_text(replace(HEARD, held=held, measured=5.1e4, object_radius=0.02))
    for said in ("100 mm in contact", "with 1.5 N", "**0.22 N** away", "0.31 N towards", "51 kPa"):
        assert said in text


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
    code = "import sys; from spiral_gripper.cli.main import run; sys.exit(run(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "studio", "--ros", "--namespace", namespace]
    with subprocess.Popen([*command, "--no-browser"], stdout=subprocess.PIPE, text=True) as page:
        said = next(line for line in page.stdout if "Ctrl-C" in line)
        assert said.startswith(f"studio of the node in {namespace}: http://")
        page.send_signal(signal.SIGINT)
        assert page.wait(PATIENCE) == 0
