# SPDX-License-Identifier: Apache-2.0
"""Designs and grips in a process of their own, without ROS."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from ros.harness import design_request, wait_until

from spiral_core import NotGrippableError
from spiral_core.grip.curve import GripQuestion
from spiral_gripper import load_description
from spiral_gripper_ros.node.design_service import requirement_from_msg
from spiral_gripper_ros.planning import design as limited_design
from spiral_gripper_ros.planning.design import design
from spiral_gripper_ros.planning.worker import (
    EndedError,
    SharedGrips,
    Worker,
    join_ended,
)

LONG = requirement_from_msg(
    design_request(
        0.011,
        0.030,
        object_length=0.25,
        fiber_angles_beta=[0.9 + 0.002 * step for step in range(250)],
    ),
    (9.80665, 0.0, 0.0),
    load_description("paper_design_70"),
)


def stuck():
    """Hold the interpreter's lock for minutes."""
    re.match(r"(a+)+$", "a" * 40 + "b")


@pytest.fixture
def worker():
    worker = Worker("answer")
    yield worker
    worker.end()


def wait_for_the_end(process_id):
    wait_until(lambda: not Path(f"/proc/{process_id}").exists())


def end_soon(worker):
    threading.Timer(0.7, worker.end, ["canceled"]).start()


def kill(worker):
    os.kill(worker.answer(os.getpid), signal.SIGKILL)


@pytest.mark.parametrize(
    ("before", "question", "why", "lives"),
    [
        (Worker, (design, LONG, 3.0), "not done within 3 s of processor time", True),
        (Worker.end, (os.getpid,), "no answer: the node has ended", False),
        (end_soon, (stuck,), "no answer: canceled", False),
        (kill, (time.sleep, 5.0), "no answer: its process was killed", True),
    ],
)
def test_what_has_no_answer_is_ended_with_its_reason_and_its_process_too(
    worker, before, question, why, lives
):
    first = worker.answer(os.getpid)
    before(worker)
    with pytest.raises(EndedError, match=why):
        worker.answer(*question)
    assert not lives or worker.answer(os.getpid)
    worker.end()
    wait_for_the_end(first)
    with pytest.raises(EndedError):
        worker.answer(os.getpid)


def greedy(*_):
    raise MemoryError


def greedy_design():
    limited_design.design_gripper = greedy
    design(LONG)


def test_a_design_that_needs_too_much_memory_is_an_answer(worker):
    with pytest.raises(EndedError, match="more than 2 GB of memory"):
        worker.answer(greedy_design)


def test_what_nobody_waits_for_any_more_is_ended_and_the_next_question_is_answered(worker):
    process_id, wanted = worker.answer(os.getpid), threading.Event()
    wanted.set()
    threading.Timer(0.5, wanted.clear).start()
    start = time.monotonic()
    for question in ((time.sleep, 60.0), (os.getpid,)):
        with pytest.raises(EndedError, match="nobody waits"):
            worker.answer(*question, is_wanted=wanted.is_set)
    assert time.monotonic() - start < 20.0
    wait_for_the_end(process_id)
    assert worker.answer(os.getpid) != process_id


def processes():
    """Return the processes of this one."""
    return set(map(int, Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()))


def test_nodes_of_one_program_share_a_process_that_ends_with_the_last(gripper):
    before, seen = processes(), []
    first, second = SharedGrips(), SharedGrips()
    for shared in (first, second, second):
        with pytest.raises(NotGrippableError):
            shared.answer(GripQuestion(gripper, 0.2), lambda: True)
        seen.append(processes() - before)
        first.end()
    with pytest.raises(EndedError, match="the node has ended"):
        first.answer(GripQuestion(gripper, 0.02), lambda: True)
    second.end()
    (process_id,) = seen[0]
    assert seen == [{process_id}] * 3
    wait_for_the_end(process_id)


def test_one_process_computes_behind_all_others_and_hears_no_terminal(worker):
    assert worker.answer(os.nice, 0) == os.nice(0) + 5
    ids = [worker.submit(ask, *of).result() for ask, *of in ((os.getsid, 0), (os.getpid,))]
    assert ids[0] == ids[1] != os.getsid(0)


def test_nothing_that_was_started_for_it_outlives_a_program_that_waits(worker):
    before = set(threading.enumerate())
    worker.submit(stuck)
    worker.end()
    join_ended()
    assert set(threading.enumerate()) <= before


PROGRAM = """
import os, time
print('started', flush=True)
from spiral_gripper_ros.planning.worker import Worker
worker = Worker('answer')
print(worker.answer(os.getpid), flush=True)
worker.submit(time.sleep, 60.0)
time.sleep(60.0)
"""


def test_the_programs_main_module_does_not_run_again_and_who_is_killed_leaves_nothing(tmp_path):
    """Without a guard: a node that it starts would run twice, and command twice."""
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    with subprocess.Popen([sys.executable, program], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"started\n"
        worker_id = int(process.stdout.readline())
        process.kill()
        assert process.stdout.read() == b""
    assert worker_id != process.pid
    wait_for_the_end(worker_id)
