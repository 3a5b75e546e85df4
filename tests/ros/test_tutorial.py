# SPDX-License-Identifier: Apache-2.0
"""The tutorial's commands for a running gripper, simulated and with a device on a serial line."""

import re
import shlex
import signal
from contextlib import contextmanager
from pathlib import Path

import pytest
from ros.harness import wait_until
from ros.programs import PROGRAM, line_with, rest_of, start
from ros.regulator_devices import LineDevice

from spiral_gripper.cli.main import run

PAGE = (Path(__file__).parents[2] / "docs" / "tutorial.md").read_text(encoding="utf-8")

pytestmark = pytest.mark.slow


def commands_of(heading):
    """Return the lines of the shell blocks below a heading of the page."""
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return "".join(re.findall(r"```bash\n(.*?)```", section, re.DOTALL)).splitlines()


def asked(line):
    """Run a command of the page here; return whether it succeeds."""
    return run(shlex.split(line)[1:]) == 0


@pytest.fixture(autouse=True)
def designed(tmp_path, monkeypatch):
    """The folder in which the tutorial's reader has arrived at this point."""
    monkeypatch.chdir(tmp_path)
    text = re.search(r"```yaml\n(name: my_gripper.*?)```", PAGE, re.DOTALL)[1]
    Path("designed.yaml").write_text(text, encoding="utf-8")


@contextmanager
def running(line):
    """A program of the page while the block runs; Ctrl-C ends it, with exit code 0."""
    program, *arguments = shlex.split(line)
    with start(str(Path(PROGRAM).with_name(program)), *arguments) as process:
        try:
            yield process
        finally:
            code, said = rest_of(process, signal.SIGINT)
        assert code == 0, said


def wait_for(device, pressure, within=0.02):
    """Wait until a device has a pressure [Pa], within a fraction of it."""
    wait_until(lambda: device.pressure == pytest.approx(pressure, rel=within))


def test_the_simulated_gripper_plans_grasps_and_releases():
    simulate, *questions = commands_of("7. Command it without hardware")
    assert len(questions) == 4
    with running(simulate) as process:
        line_with(process, "perfect wrap")
        assert all(map(asked, questions))


def test_a_regulator_on_a_serial_line_gets_the_pressure_and_is_vented():
    node, adapter, grasp, release = commands_of("8. Wire a regulator")
    device = LineDevice()
    with running(node), running(adapter.replace("/dev/ttyACM0", device.port)):
        # On a busy machine readings may be late, which a goal is refused for: it is asked again.
        assert any(asked(grasp) for _ in range(200))
        wait_for(device, 78.7e3 * 1.05, within=0.06)  # recommended, or 1.1 times before it is known
        assert asked(release)
        wait_for(device, 0.0)
    device.close()
