# SPDX-License-Identifier: Apache-2.0
"""The pages that show how: their commands run in order, and print what the pages say."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import shutil
from pathlib import Path

import pytest

from spiral_core.grip import grip
from spiral_gripper.cli.main import run

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
# Commands of a running gripper: tests/ros/test_tutorial.py.
OF_A_NODE = ("simulate", "plan", "grasp", "status", "release")
FILES = {"name: my_gripper": "my_gripper.yaml", "name: my latex": "my_tubing.yaml"}


def blocks(page: str) -> list[tuple[str, str]]:
    """Return language and text of a page's blocks, in order."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return [(match[1], match[2]) for match in BLOCK.finditer(text)]


def printed_by(line: str) -> str:
    """Run one line of a page and return what it prints."""
    program, *arguments = shlex.split(line)
    output = io.StringIO()
    if program == "cp":
        for path in ROOT.glob(arguments[0]):
            shutil.copy(path, arguments[1])
    elif program == "spiral-gripper" and arguments[0] not in OF_A_NODE:
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
            code = run(arguments)
        assert code == 0, f"{line}: {output.getvalue()}"
    else:
        assert arguments[0] in OF_A_NODE or program in {
            "spiral_gripper_node",
            "spiral_gripper_regulator",
        }
    return output.getvalue()


@pytest.mark.timeout(3000)  # all that a page computes, on a busy machine
@pytest.mark.parametrize(
    "page",
    ["tutorial.md", "building.md", pytest.param("how_to.md", marks=pytest.mark.slow)],
)
def test_a_pages_commands_run_and_print_what_it_says(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(grip, "FORCE_PRESSURES", 3)  # no page states forces at all ten
    printed = ""
    for language, text in blocks(page):
        if language == "yaml":
            (name,) = [file for start, file in FILES.items() if text.startswith(start)]
            Path(name).write_text(text, encoding="utf-8")
        elif language == "bash":
            printed = "".join(map(printed_by, text.strip().splitlines()))
        elif language == "python":
            output = io.StringIO()
            with contextlib.redirect_stdout(output):
                exec(compile(text, page, "exec"), {"__name__": "__main__"})
            printed = output.getvalue()
        elif language == "text":
            missing = [line for line in text.splitlines() if line not in printed]
            assert not missing, printed


def test_the_tutorials_files_are_the_examples() -> None:
    shown = dict(blocks("tutorial.md"))
    assert "yaml" in shown
    texts = [text for language, text in blocks("tutorial.md") if language == "yaml"]
    assert texts[0] == (ROOT / "examples/data/my_gripper.yaml").read_text(encoding="utf-8")
    page = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    first, second = [
        line
        for line in (ROOT / "examples/data/bench_extension.csv").read_text().splitlines()
        if not line.startswith("#")
    ][:2]
    assert f"```\n{first}\n{second}\n```" in page
