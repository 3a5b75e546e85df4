# SPDX-License-Identifier: Apache-2.0
"""The doctor without ROS: every check's branches, its workers' crashes, and what it prints."""

from __future__ import annotations

import hashlib
import io
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from textwrap import dedent
from types import SimpleNamespace

import pytest
from rich.console import Console

from spiral_gripper import available_grippers
from spiral_gripper.cli.main import run
from spiral_gripper.cli.ros import side as ros_side
from spiral_gripper.doctor.checks import Answer, Check, Facts, Finding, Mark, finding_of
from spiral_gripper.doctor.gripper import (
    KernelCache,
    add_called,
    check_cache,
    check_gripper,
    check_kernels,
    is_kept,
    kernels_finding,
)
from spiral_gripper.doctor.install import (
    check_libraries,
    check_pictures,
    check_python,
    checks,
    too_old,
)
from spiral_gripper.doctor.package import Installation, check_package, copies_of, why_no_ros
from spiral_gripper.doctor.report import as_document, has_problem, print_answer, verdict
from spiral_gripper.doctor.run import TABLES, examine
from spiral_gripper.doctor.worker import finding_as_dict, finding_from_dict

pytestmark = pytest.mark.long

LIBRARIES = {
    "numpy": "2.1.0", "scipy": "1.14.1", "numba": "0.61.0", "pint": "0.24", "ruamel-yaml": "0.18.6",
}  # fmt: skip
HEALTHY = Facts(
    environ={},
    distributions={**LIBRARIES, "matplotlib": "3.10.8"},
    search_path=(),
    system="Linux",
    architecture="x86_64",
    python=(3, 12, 3),
    prefix=Path("/env"),
    root=Path("/"),
)
WHEEL = Installation("0.1.0", "", False, Path("/env/lib"), Path("/env/lib/spiral_gripper"))
ALL_WELL = Finding(Mark.OK, "all well")
LONG = "a finding of many words " * 10


def answer(finding: Finding, name: str = "one.check") -> Answer:
    return Answer("One", name, "a check", finding, 0.0)


def examined(table: str, **options: object) -> list[Answer]:
    return list(examine(table, None, lambda title: None, **options))


def printed(finding: Finding, width: int) -> list[str]:
    console = Console(file=io.StringIO(), width=width, highlight=False)
    print_answer(answer(finding), console)
    return console.file.getvalue().splitlines()


# --- the checks ----------------------------------------------------------------------------------


def test_the_tables_of_a_healthy_machine_have_no_problems() -> None:
    answers = [found for table in TABLES for found in examined(table)]
    assert not has_problem(answers), as_document(answers)
    names = {found.name for found in answers}
    assert {f"grippers.{gripper}" for gripper in available_grippers()} <= names
    assert {check.name for check in checks(HEALTHY)} <= names


def test_an_old_python_is_a_problem_with_a_command() -> None:
    assert check_python(HEALTHY).mark is Mark.OK
    finding = check_python(replace(HEALTHY, python=(3, 9, 1)))
    assert finding.mark is Mark.PROBLEM
    assert finding.commands


@pytest.mark.parametrize(
    ("distributions", "load", "requirements", "text"),
    [
        ({k: v for k, v in LIBRARIES.items() if k != "scipy"}, str, ["x>=1"], "scipy is not inst"),
        (LIBRARIES, str, ["numpy>=2.2"], "numpy 2.1.0 is older than 2.2"),
        (LIBRARIES, lambda name: 1 / (name != "numba"), ["x>=1"], "numba does not import: div"),
    ],
)
def test_libraries_that_do_not_fit_are_a_problem(distributions, load, requirements, text) -> None:
    finding = check_libraries(replace(HEALTHY, distributions=distributions), load, requirements)
    assert finding.mark is Mark.PROBLEM
    assert text in finding.text
    assert finding.commands[0].startswith("/env/bin/python -m pip install --upgrade")


def test_requirements_of_extras_and_newer_versions_are_fine() -> None:
    assert too_old(LIBRARIES, ['numpy>=9; extra == "test"', "numpy>=2.1", "absent>=1"]) == {}


def test_pictures_are_not_needed() -> None:
    assert check_pictures(HEALTHY).mark is Mark.OK
    assert check_pictures(replace(HEALTHY, distributions=LIBRARIES)).mark is Mark.INFO


def test_each_kind_of_installation_is_named() -> None:
    editable = replace(WHEEL, source="/home/me/clone", editable=True)
    in_workspace = replace(HEALTHY, environ={"COLCON_PREFIX_PATH": "/ws/install"})
    built = replace(WHEEL, location=Path("/ws/install/spiral_gripper/lib/python3.12/site-packages"))
    assert "a wheel, in /env/lib" in check_package(HEALTHY, WHEEL).text
    assert "editable, from /home/me/clone" in check_package(HEALTHY, editable).text
    assert "built by colcon in /ws" in check_package(in_workspace, built).text
    assert check_package(HEALTHY, replace(WHEEL, version=None)).mark is Mark.WARNING


def test_a_second_installation_on_the_path_is_a_warning(tmp_path: Path) -> None:
    folders = []
    for name in ("first", "second"):
        folders.append(tmp_path / name / "spiral_gripper")
        folders[-1].mkdir(parents=True)
        (folders[-1] / "__init__.py").touch()
    (tmp_path / "no_package" / "spiral_gripper").mkdir(parents=True)
    path = tuple(tmp_path / name for name in ("first", "no_package", "second", "first"))
    facts = replace(HEALTHY, search_path=path)
    assert copies_of("spiral_gripper", facts) == folders
    finding = check_package(facts, replace(WHEEL, package=folders[0]))
    assert finding.mark is Mark.WARNING
    assert f"also in {folders[1]}" in finding.text


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"system": "Darwin", "architecture": "arm64"}, "for Linux x86_64 only"),
        ({"architecture": "aarch64"}, "for Linux x86_64 only"),
        ({"python": (3, 14, 0)}, "this is 3.14"),
        ({}, "SPIRAL_WITHOUT_ROS"),
    ],
)
def test_where_there_is_no_ros_the_reason_is_said(change, text) -> None:
    finding = why_no_ros(replace(HEALTHY, **change))
    assert finding.mark is Mark.INFO
    assert text in finding.text
    assert finding.commands


@pytest.mark.parametrize(
    ("kernels", "mark", "text"),
    [(60, Mark.OK, "all 60"), (0, Mark.INFO, "60 of 60"), (40, Mark.INFO, "20 of 60")],
)
def test_what_is_not_compiled_is_said_before_it_is(kernels, mark, text) -> None:
    finding = check_cache(HEALTHY, KernelCache(60, kernels, Path("/cache")))
    assert finding.mark is mark
    assert text in finding.text


def test_a_kernel_is_kept_while_its_source_says_the_same(tmp_path: Path) -> None:
    """A source that was written again, to the same text, needs no compilation."""
    source, index = tmp_path / "kernels.py", tmp_path / "kernels.kernel-1.py311.nbi"
    source.write_text("def kernel(): ...", encoding="utf-8")
    names: dict[str, object] = {}
    exec(compile(source.read_text(encoding="utf-8"), str(source), "exec"), names)
    kernel = SimpleNamespace(
        py_func=names["kernel"], stats=SimpleNamespace(cache_path=str(tmp_path))
    )
    assert not is_kept(kernel)
    index.write_bytes(b"version" + hashlib.sha256(source.read_bytes()).digest() + b"overloads")
    os.utime(index, (0.0, 0.0))
    assert is_kept(kernel)
    source.write_text("def kernel(): return 1", encoding="utf-8")
    assert not is_kept(kernel)
    later = source.stat().st_mtime + 1.0
    os.utime(index, (later, later))
    assert is_kept(kernel)


def test_a_kernel_that_is_kept_holds_all_that_it_calls() -> None:
    from spiral_core.rod._continuation import solve_uniform

    names: set[str] = set()
    add_called(solve_uniform.py_func, names)  # type: ignore[attr-defined]
    kernels = {name.rpartition("_")[0] or name for name in names}
    assert kernels >= {"solve_uniform", "uniform_system", "minimize", "element_derivatives", "dot"}
    assert not kernels & {"fitted_radius", "solve_system"}


def test_kernels_that_cannot_be_compiled_are_a_problem() -> None:
    finding = check_cache(replace(HEALTHY, environ={"NUMBA_DISABLE_JIT": "1"}))
    assert finding.mark is Mark.PROBLEM
    assert finding.commands == ("unset NUMBA_DISABLE_JIT",)


def test_a_start_says_whether_it_compiled_and_whether_that_was_kept() -> None:
    none, every = KernelCache(60, 0, Path("/cache")), KernelCache(60, 60, Path("/cache"))
    assert kernels_finding(0.5, every, every).text == "loaded in 0.5 s"
    assert kernels_finding(31.0, none, every).text.startswith("compiled in 31 s")
    assert kernels_finding(31.0, none, none).mark is Mark.WARNING


def test_the_kernels_that_are_counted_are_those_of_a_start() -> None:
    code = dedent("""
        from spiral_gripper.doctor.gripper import KernelCache
        counted = KernelCache.here().kernels
        from spiral_core import WrapCurve
        from spiral_gripper import load_gripper
        WrapCurve(load_gripper("prototype_p1")).wrap_for_radius(0.01)
        print(counted, KernelCache.here().kernels)
    """)
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    before, after = run.stdout.split()
    assert before == after
    assert int(after) > 20


def test_kernels_load() -> None:
    assert check_kernels(HEALTHY).mark is Mark.OK


def test_a_gripper_that_cannot_be_used_is_a_problem_with_its_place(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("name: mine\ntube:\n  length: 0 mm\n")
    for name, text in (("prototype", "prototype_p1"), (str(file), "mine.yaml:")):
        finding = check_gripper(name, HEALTHY)
        assert finding.mark is Mark.PROBLEM
        assert text in finding.text
    assert "grips radii from 2.591 mm to 35.59 mm" in check_gripper("prototype_p1", HEALTHY).text


# --- the workers ---------------------------------------------------------------------------------


@pytest.fixture
def broken_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A table of checks that go wrong in every way, on the path of workers only."""
    (tmp_path / "broken_table.py").write_text(
        dedent("""
            import os, sys, time
            from spiral_gripper.doctor.checks import Check, Finding, Mark

            SECTION = "Broken"

            def well(facts):
                print("a library prints this")
                return Finding(Mark.OK, "still here")

            def crash(facts):
                raise ValueError("bad\\nvalue")

            def end(facts):
                print("terminate called", file=sys.stderr)
                os._exit(3)

            def abort(facts):
                os.abort()

            def hang(facts):
                time.sleep(600.0)

            def checks(facts):
                return (
                    Check("b.first", "first", well),
                    Check("b.crash", "crash", crash),
                    Check("b.end", "end", end),
                    Check("b.abort", "abort", abort),
                    Check("b.hang", "hang", hang, time_limit=1.0),
                    Check("b.needy", "needy", well, ("b.first", "b.end")),
                    Check("b.last", "last", well, ("b.first",)),
                )
        """)
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return "broken_table"


def test_checks_that_crash_or_hang_are_problems_and_the_others_go_on(broken_table: str) -> None:
    found = {each.name: each.finding for each in examined(broken_table)}
    assert list(found) == [
        "b.first", "b.crash", "b.end", "b.abort", "b.hang", "b.needy", "b.last"
    ]  # fmt: skip
    assert found["b.first"] == found["b.last"] == Finding(Mark.OK, "still here")
    for name, text in (
        ("b.crash", "this check crashed: ValueError: bad (broken_table.py:"),
        ("b.end", "this check crashed: exit code 3, terminate called"),
        ("b.abort", "this check crashed: SIGABRT"),
        ("b.hang", "no answer within 1 s"),
    ):
        assert found[name].mark is Mark.PROBLEM
        assert found[name].text.startswith(text)
    assert found["b.needy"] == Finding(Mark.SKIPPED, "not checked, because of end")


def test_a_table_that_cannot_be_loaded_is_one_problem() -> None:
    (only,) = examined("spiral_gripper.doctor_of_nothing")
    assert only.finding.mark is Mark.PROBLEM
    assert "No module named 'spiral_gripper.doctor_of_nothing'" in only.finding.text


def test_a_worker_that_never_begins_is_given_up() -> None:
    (only,) = examined(TABLES[0], start_limit=0.0)
    assert only.finding.text.startswith("no answer within 0 s")


def test_a_check_that_raises_is_a_finding_and_skips_what_needs_it() -> None:
    ending = Check("a", "a", lambda facts: sys.exit(102))
    assert "crashed: SystemExit: 102" in finding_of(ending, HEALTHY, {}).text
    needy = Check("b", "b", lambda facts: ALL_WELL, ("a",))
    assert finding_of(needy, HEALTHY, {"a": Mark.WARNING}) == ALL_WELL
    for mark in (Mark.PROBLEM, Mark.SKIPPED):
        assert finding_of(needy, HEALTHY, {"a": mark}).mark is Mark.SKIPPED


def test_findings_survive_their_way_between_processes() -> None:
    finding = Finding(Mark.WARNING, "text", "advice", ("one", "two"))
    assert finding_from_dict(json.loads(json.dumps(finding_as_dict(finding)))) == finding


# --- what is printed -----------------------------------------------------------------------------


@pytest.mark.parametrize("width", [10, 80, 120])
def test_lines_keep_to_the_width_and_commands_stay_whole(width: int) -> None:
    command = "env -u " + " -u ".join(f"VARIABLE_{i}" for i in range(20))
    lines = printed(Finding(Mark.WARNING, LONG, LONG, (command,)), width)
    assert lines[-1].strip() == command
    assert lines[0].startswith("warning  a check            a finding")
    assert max(len(line) for line in lines[:-1]) <= max(width, 50)
    assert not any(line != line.rstrip() for line in lines)


def test_the_verdict_counts() -> None:
    warning, problem = Finding(Mark.WARNING, ""), Finding(Mark.PROBLEM, "")
    assert verdict([answer(ALL_WELL)]) == "all well: 1 checks"
    assert verdict([answer(warning), answer(warning)]) == "no problems, 2 warnings"
    assert verdict([answer(problem), answer(ALL_WELL)]) == "1 problem, no warnings"
    assert not has_problem([answer(warning)])
    assert as_document([answer(problem)])["problems"] == 1


def command(*arguments: str, **environ: str) -> subprocess.CompletedProcess[str]:
    code = "import sys; from spiral_gripper.cli.main import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, "doctor", *arguments],
        capture_output=True,
        text=True,
        env={**os.environ, **environ},
        check=False,
    )


@pytest.mark.slow
def test_a_gripper_by_its_path_is_looked_at_instead_of_the_shipped_ones(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("name: mine\n")
    done = command(str(file), "--json")
    document = json.loads(done.stdout)
    assert done.returncode == 1
    (found,) = (each for each in document["checks"] if each["title"] == "mine")
    assert found["mark"] == "problem"
    assert not [each for each in document["checks"] if each["title"] in available_grippers()]


def test_what_people_read_has_no_color_in_a_pipe() -> None:
    done = command("prototype_p1", COLUMNS="80", NUMBA_DISABLE_JIT="1")
    assert done.returncode == 1
    assert done.stderr == ""
    assert "\x1b" not in done.stdout
    assert done.stdout.startswith("Installation\nok       Python             3.")
    assert "PROBLEM  kernel cache       NUMBA_DISABLE_JIT is set" in done.stdout
    assert "skipped  prototype_p1       not checked, because of kernel cache" in done.stdout


def test_without_ros_a_smoke_test_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ros_side, "find_spec", lambda name: None)
    assert run(["smoke"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("spiral-gripper: this command needs ROS 2")
    assert captured.err.count("\n") == 1
