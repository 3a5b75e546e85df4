# SPDX-License-Identifier: Apache-2.0
"""The doctor: all well here, and what is broken is named."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from click.testing import CliRunner

from spiral_gripper.cli import doctor

pytestmark = pytest.mark.long


def diagnosed(*arguments: str) -> tuple[int, dict[str, dict[str, object]]]:
    """Return the exit code, and what was found by name."""
    result = CliRunner().invoke(doctor.doctor, [*arguments, "--json"], standalone_mode=False)
    document = json.loads(result.stdout)
    assert document["problems"] == sum(each["problem"] for each in document["checks"])
    return int(result.return_value), {each["name"]: each for each in document["checks"]}


def test_a_working_installation_is_well() -> None:
    command = [sys.executable, "-m", "spiral_gripper.cli.main", "doctor", "prototype_p1", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    found = {each["name"]: each for each in json.loads(done.stdout)["checks"]}
    assert list(found) == ["versions", "kernels", "prototype_p1", "grip", "node"]
    assert "Python" in str(found["versions"]["text"])
    assert "tip criterion for radii from 2.59" in str(found["prototype_p1"]["text"])
    assert "an object of 9.604 mm" in str(found["grip"]["text"])
    answer = "an object of 9.604 mm" if find_spec("rclpy") else "not installed"
    assert answer in str(found["node"]["text"])


def test_a_broken_file_ends_the_examination(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("name: mine\n")
    code, found = diagnosed(str(tmp_path / "mine.yaml"))
    assert (code, len(found)) == (1, 3)
    assert "tube.length" in str(found[str(tmp_path / "mine.yaml")]["text"])


@pytest.mark.parametrize(
    ("name", "error", "said"),
    [
        ("check_versions", ImportError("numba needs another numpy"), "another numpy"),
        ("check_kernels", SystemExit(3), "SystemExit: 3"),
    ],
)
def test_what_fails_is_a_problem(
    monkeypatch: pytest.MonkeyPatch, name: str, error: BaseException, said: str
) -> None:
    def fail(*_: object) -> str:
        raise error

    monkeypatch.setattr(doctor, name, fail)
    code, found = diagnosed("prototype_p1")
    assert code == 1
    assert said in str(found[name.removeprefix("check_")]["text"])
