# SPDX-License-Identifier: Apache-2.0
"""The doctor's look at ROS 2: each branch with broken facts, and the whole on this machine."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from ros.harness import DEADLINE
from std_msgs.msg import Float64

from spiral_gripper.doctor import gripper as doctor_gripper
from spiral_gripper.doctor import install as doctor_install
from spiral_gripper.doctor.checks import Facts, Mark
from spiral_gripper.doctor.run import examine, tables
from spiral_gripper_ros.doctor import checks as doctor_ros
from spiral_gripper_ros.doctor.checks import SECTION, check_rclpy, checks
from spiral_gripper_ros.doctor.domain import check_discovery, check_domain, highest_safe_domain
from spiral_gripper_ros.doctor.environment import (
    check_distribution,
    check_middleware_name,
    check_start,
)
from spiral_gripper_ros.doctor.graph import Grippers, check_grippers, grippers_finding
from spiral_gripper_ros.doctor.interfaces import (
    check_interfaces,
    missing_constants,
)
from spiral_gripper_ros.doctor.memory import (
    MEGABYTE,
    SharedMemory,
    check_leftovers,
    check_room,
    leftovers_finding,
    room_finding,
)
from spiral_gripper_ros.doctor.security import check_security
from spiral_gripper_ros.doctor.transport import (
    check_middleware,
    check_two_processes,
    round_trips,
    two_processes_finding,
)
from spiral_gripper_ros.messages.qos import LATEST

WHEELS = {"ros-jazzy-rclpy": "7.1.6", "rclpy": "7.1.5"}
COMMAND = "from spiral_gripper.cli.main import main; main()"
EMPTY = SharedMemory(Path("/dev/shm"), 512 * MEGABYTE, (), (), ())


@pytest.fixture
def facts(tmp_path):
    """A healthy machine below a folder: an environment with wheels, shared memory, /proc."""
    (tmp_path / "env/lib/python3.12/site-packages/rclpy").mkdir(parents=True)
    (tmp_path / "env/lib/python3.12/site-packages/rclpy/__init__.py").touch()
    middlewares = tmp_path / "env/share/ament_index/resource_index/rmw_typesupport"
    middlewares.mkdir(parents=True)
    for name in ("rmw_fastrtps_cpp", "rmw_implementation"):
        (middlewares / name).touch()
    (tmp_path / "dev/shm").mkdir(parents=True)
    (tmp_path / "proc/sys/net/ipv4").mkdir(parents=True)
    (tmp_path / "proc/sys/net/ipv4/ip_local_port_range").write_text("32768\t60999\n")
    (tmp_path / "proc/locks").touch()
    return Facts(
        environ={},
        distributions=WHEELS,
        search_path=(tmp_path / "env/lib/python3.12/site-packages",),
        system="Linux",
        architecture="x86_64",
        python=(3, 12, 3),
        prefix=tmp_path / "env",
        root=tmp_path,
    )


def with_rclpy(facts, folder):
    """Return the facts with another rclpy before the others on the path."""
    (folder / "rclpy").mkdir(parents=True)
    (folder / "rclpy/__init__.py").touch()
    return replace(facts, search_path=(folder, *facts.search_path))


# --- distribution, workspaces, middleware --------------------------------------------------------


def test_wheels_of_one_distribution_are_well(facts):
    finding = check_distribution(facts)
    assert finding.mark is Mark.OK
    assert finding.text == f"jazzy, wheels in {facts.prefix}"


def test_an_installation_from_apt_is_well(facts):
    folder = facts.root / "opt/ros/kilted/lib/python3.12/site-packages"
    apt = replace(with_rclpy(facts, folder), distributions={})
    apt = replace(apt, search_path=apt.search_path[:1], environ={"ROS_DISTRO": "kilted"})
    finding = check_distribution(apt)
    assert finding.mark is Mark.OK
    assert finding.text.startswith("kilted, from ")


@pytest.mark.parametrize("installed", [False, True])
def test_without_rclpy_the_way_to_it_is_said(facts, installed):
    if installed:
        (facts.root / "opt/ros/jazzy").mkdir(parents=True)
        (facts.root / "opt/ros/jazzy/setup.bash").touch()
    finding = check_distribution(replace(facts, search_path=()))
    assert finding.mark is Mark.PROBLEM
    expected = f"source {facts.root}/opt/ros/jazzy/setup.bash" if installed else "make install"
    assert finding.commands == (expected,)


def test_wheels_of_two_distributions_are_a_problem(facts):
    finding = check_distribution(
        replace(facts, distributions={**WHEELS, "ros-kilted-rclpy": "9.1.0"})
    )
    assert finding.mark is Mark.PROBLEM
    assert "jazzy and kilted" in finding.text


def test_an_installation_for_another_python_is_a_problem(facts):
    mixed = with_rclpy(facts, facts.root / "opt/ros/humble/lib/python3.10/site-packages")
    finding = check_distribution(replace(mixed, environ={"ROS_DISTRO": "humble"}))
    assert finding.mark is Mark.PROBLEM
    assert "for another Python than this 3.12" in finding.text
    assert finding.commands[0].startswith("env -u ROS_DISTRO")


@pytest.mark.parametrize(
    ("sourced", "mark"), [("jazzy", Mark.WARNING), ("humble", Mark.PROBLEM), ("", Mark.WARNING)]
)
def test_two_installations_in_one_terminal_are_noticed(facts, sourced, mark):
    twice = with_rclpy(facts, facts.root / "opt/ros/other/lib/python3.12/site-packages")
    finding = check_distribution(replace(twice, environ={"ROS_DISTRO": sourced}))
    assert finding.mark is mark
    assert "here 2 times" in finding.text
    if sourced:
        alone = check_distribution(replace(facts, environ={"ROS_DISTRO": sourced}))
        assert alone.mark is mark
        assert f"a setup file of {sourced} was sourced" in alone.text


def test_a_distribution_that_nobody_tried_is_a_warning(facts):
    finding = check_distribution(replace(facts, distributions={"ros-rolling-rclpy": "9.9"}))
    assert finding.mark is Mark.WARNING


def test_the_mark_of_another_pythons_wheels_is_a_problem(facts):
    marked = replace(facts, environ={"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"})
    assert check_start(marked).mark is Mark.PROBLEM
    libraries = {**marked.environ, "LD_LIBRARY_PATH": f"/other:{facts.prefix}/lib"}
    assert check_start(replace(facts, environ=libraries)).mark is Mark.OK
    assert check_start(replace(marked, distributions={})).mark is Mark.OK


def test_the_packages_of_a_workspace_are_shown_as_one(facts):
    folders = [facts.root / "install" / name for name in "abc"]
    for folder in folders:
        folder.mkdir(parents=True)
    path = ":".join(str(folder) for folder in (*folders, facts.prefix))
    finding = check_start(replace(facts, environ={"AMENT_PREFIX_PATH": path}))
    assert finding.text == f"AMENT_PREFIX_PATH: {facts.root}/install/* (3), {facts.prefix}"


def test_a_workspace_that_is_gone_is_a_warning(facts):
    here, gone = str(facts.root), "/no/such/workspace"
    well = check_start(replace(facts, environ={"AMENT_PREFIX_PATH": here}))
    assert well.mark is Mark.OK
    assert here in well.text
    stale = check_start(replace(facts, environ={"AMENT_PREFIX_PATH": f"{here}:{gone}"}))
    assert stale.mark is Mark.WARNING
    assert gone in stale.text


def test_a_middleware_that_is_not_installed_is_a_problem(facts):
    assert check_middleware_name(facts).text == "the default one; installed: rmw_fastrtps_cpp"
    for name, mark in (("rmw_fastrtps_cpp", Mark.OK), ("rmw_zenoh_cpp", Mark.PROBLEM)):
        assert check_middleware_name(
            replace(facts, environ={"RMW_IMPLEMENTATION": name})
        ).mark is mark  # fmt: skip


# --- domain, discovery ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "mark"),
    [
        ("", Mark.OK), ("0", Mark.OK), ("101", Mark.OK), ("102", Mark.WARNING),
        ("214", Mark.WARNING), ("215", Mark.OK), ("232", Mark.OK), ("233", Mark.PROBLEM),
        ("-1", Mark.PROBLEM), ("abc", Mark.PROBLEM), ("1.5", Mark.PROBLEM), ("²", Mark.PROBLEM),
        ("9" * 40, Mark.PROBLEM),
    ],
)  # fmt: skip
def test_a_domain_must_be_a_number_whose_ports_are_free(facts, text, mark):
    assert check_domain(replace(facts, environ={"ROS_DOMAIN_ID": text})).mark is mark


def test_the_machine_says_which_domains_are_safe(facts):
    ports = facts.root / "proc/sys/net/ipv4/ip_local_port_range"
    assert highest_safe_domain(facts) == 101
    ports.write_text("10000 60999")
    assert highest_safe_domain(facts) == 10
    ports.write_text("9950 60999")
    assert highest_safe_domain(facts) == 9
    assert check_domain(replace(facts, environ={"ROS_DOMAIN_ID": "10"})).mark is Mark.WARNING
    ports.unlink()
    assert highest_safe_domain(facts) == 101


def test_a_machine_whose_outgoing_connections_take_all_ports_has_no_safe_domain(facts):
    (facts.root / "proc/sys/net/ipv4/ip_local_port_range").write_text("1024 65535")
    found = check_domain(replace(facts, environ={"ROS_DOMAIN_ID": "5"}))
    assert highest_safe_domain(facts) < 0
    assert found.mark is Mark.WARNING
    assert "-" not in found.advice
    assert found.commands == ("sudo sysctl -w net.ipv4.ip_local_port_range='32768 60999'",)


@pytest.mark.parametrize(
    ("environ", "mark", "text"),
    [
        ({}, Mark.OK, "SUBNET, the default"),
        ({"ROS_STATIC_PEERS": "robot"}, Mark.OK, "besides robot"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, Mark.OK, "nodes on this machine find"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "localhost"}, Mark.WARNING, "counts as LOCALHOST"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}, Mark.WARNING, "no node hears another"),
        ({"ROS_LOCALHOST_ONLY": "1"}, Mark.INFO, "nodes on this machine find"),
        ({"ROS_LOCALHOST_ONLY": "0"}, Mark.OK, "SUBNET"),
        (
            {"ROS_LOCALHOST_ONLY": "1", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"},
            Mark.WARNING,
            "nodes on this machine find",
        ),
    ],
)
def test_who_hears_whom_is_explained(facts, environ, mark, text):
    finding = check_discovery(replace(facts, environ=environ))
    assert finding.mark is mark
    assert text in finding.text


@pytest.mark.parametrize(
    ("environ", "keys", "mark"),
    [
        ({}, False, Mark.INFO),
        ({"ROS_SECURITY_ENABLE": "True"}, False, Mark.WARNING),
        ({"ROS_SECURITY_ENABLE": "true"}, False, Mark.WARNING),
        ({"ROS_SECURITY_ENABLE": "true"}, True, Mark.WARNING),
        ({"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"}, False, Mark.PROBLEM),
        ({"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"}, True, Mark.SKIPPED),
        (
            {
                "ROS_SECURITY_ENABLE": "true",
                "ROS_SECURITY_STRATEGY": "Enforce",
                "ROS_SECURITY_ENCLAVE_OVERRIDE": "/mine",
            },
            True,
            Mark.OK,
        ),
    ],
)
def test_security_needs_its_keys(facts, environ, keys, mark):
    if keys:
        (facts.root / "keys/enclaves/mine").mkdir(parents=True)
        (facts.root / "keys/enclaves/mine/cert.pem").touch()
        environ = {**environ, "ROS_SECURITY_KEYSTORE": str(facts.root / "keys")}
    finding = check_security(replace(facts, environ=environ))
    assert finding.mark is mark
    assert bool(finding.commands) is (mark not in (Mark.OK, Mark.INFO))


# --- shared memory -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("megabytes", "mark"), [(64, Mark.OK), (16, Mark.WARNING), (1, Mark.PROBLEM)]
)
def test_little_room_in_shared_memory_is_noticed(megabytes, mark):
    assert room_finding(replace(EMPTY, free=megabytes * MEGABYTE)).mark is mark


def test_files_without_a_lock_are_left_over(facts):
    folder = facts.root / "dev/shm"
    names = ("fastrtps_0123456789abcdef", "fastrtps_port7411")
    for name in names:
        (folder / name).touch()
        (folder / f"{name}_el").touch()
    (folder / "somebody_elses").touch()
    held = (folder / f"{names[0]}_el").stat()
    device = f"{os.major(held.st_dev):02x}:{os.minor(held.st_dev):02x}"
    (facts.root / "proc/locks").write_text(
        f"1: FLOCK  ADVISORY  WRITE 26715 {device}:{held.st_ino} 0 EOF\n"
    )
    memory = SharedMemory.of(facts)
    assert memory.in_use == (f"{names[0]}_el",)
    assert memory.left == (f"{names[1]}_el",)
    finding = check_leftovers(facts)
    assert finding.mark is Mark.WARNING
    assert finding.commands == ("fastdds shm clean",)
    (facts.root / "proc/locks").unlink()
    assert check_leftovers(facts).mark is Mark.OK


def test_nodes_of_other_users_are_a_warning():
    port = ("fastrtps_port7411_el",)
    running = leftovers_finding(replace(EMPTY, in_use=port, foreign=port), "clean")
    assert running.mark is Mark.WARNING
    assert running.commands == ("export FASTDDS_BUILTIN_TRANSPORTS=UDPv4",)
    memory = replace(EMPTY, left=(*port, "fastrtps_port7413_el"), foreign=port)
    dead = leftovers_finding(memory, "c")
    assert dead.text.startswith("2 locks of Fast DDS are left")
    assert dead.text.endswith("1 of them of other users")
    assert dead.commands == ("sudo c",)
    assert leftovers_finding(memory, "c", root=True).commands == ("c",)
    assert leftovers_finding(replace(EMPTY, in_use=port), "clean").mark is Mark.OK


def test_where_there_is_no_shared_memory_that_is_said(facts):
    (facts.root / "dev/shm").rmdir()
    assert check_room(facts).mark is check_leftovers(facts).mark is Mark.INFO


# --- interfaces ----------------------------------------------------------------------------------


def test_the_interfaces_here_are_those_that_are_used(facts):
    assert check_interfaces(facts).mark is Mark.OK


def test_interfaces_of_an_older_version_are_a_problem(facts):
    class OldStatus:
        STATE_INACTIVE = 0

    def without_constants(_name):
        return SimpleNamespace(GripStatus=OldStatus)

    finding = check_interfaces(facts, without_constants)
    assert finding.mark is Mark.PROBLEM
    assert "GripStatus has no STATE_" in finding.text
    assert "STATE_GRASPING" in finding.text
    assert finding.commands == ("make install",)
    assert "STATE_INACTIVE" not in missing_constants(OldStatus)
    built = replace(facts, environ={"COLCON_PREFIX_PATH": "/ws/install"})
    assert "colcon build" in check_interfaces(built, without_constants).commands[0]

    def without_interface(name):
        if name.endswith("gripper_node"):
            raise ImportError("cannot import name 'Release' from 'spiral_gripper_msgs.action'")
        return SimpleNamespace(GripStatus=OldStatus)

    finding = check_interfaces(facts, without_interface)
    assert finding.mark is Mark.PROBLEM
    assert "cannot import name 'Release'" in finding.text


def test_interfaces_that_were_never_compiled_are_a_problem(facts):
    def load(name):
        raise ModuleNotFoundError(f"No module named {name!r}")

    finding = check_interfaces(facts, load)
    assert finding.mark is Mark.PROBLEM
    assert "No module named 'spiral_gripper_msgs.msg'" in finding.text


# --- messages, other nodes -----------------------------------------------------------------------


def test_messages_arrive_here(facts):
    for check in (check_middleware, check_two_processes):
        finding = check(facts)
        assert finding.mark is Mark.OK, finding


def test_messages_that_do_not_arrive_are_a_problem(facts):
    assert round_trips("/nobody/listens", "/nobody/answers", deadline=0.3) == []
    finding = two_processes_finding([], facts)
    assert finding.mark is Mark.PROBLEM
    assert any("FASTDDS_BUILTIN_TRANSPORTS=UDPv4" in line for line in finding.commands)
    off = replace(facts, environ={"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"})
    assert two_processes_finding([], off).commands == ("unset ROS_AUTOMATIC_DISCOVERY_RANGE",)


def test_two_nodes_on_one_valve_are_a_warning(facts, client, namespace):
    topic = f"{namespace}/pressure_command"
    client.create_publisher(Float64, topic, LATEST)
    assert check_grippers(facts).mark is Mark.OK
    client.create_publisher(Float64, topic, LATEST)
    expected = f"2 nodes command {topic}: {namespace}/test_client, {namespace}/test_client"
    findings = []
    client.wait_until(
        lambda: findings.append(check_grippers(facts)) or findings[-1].text.startswith(expected),
        expected,
    )
    assert findings[-1].mark is Mark.WARNING


def test_nodes_of_one_name_are_a_warning_and_others_are_listed(facts):
    twins = Grippers({}, ("/spiral_gripper", "/spiral_gripper"))
    assert grippers_finding(twins, facts).mark is Mark.WARNING
    several = Grippers({"/a/pressure_command": ("/a/x",)}, ("/b/y", "/a/x"))
    assert grippers_finding(several, facts).text == "on domain 0: /a/x, /b/y"
    assert grippers_finding(Grippers({}, ()), facts).mark is Mark.OK


# --- the whole -----------------------------------------------------------------------------------


def test_the_version_of_rclpy_is_named(facts):
    assert check_rclpy(facts).text.startswith("7.1.5, from ")


def test_nothing_of_ros_is_loaded_with_the_table():
    code = f"import sys, {doctor_ros.__name__}; print('rclpy' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "False\n"


def test_a_healthy_machine_has_no_problems(facts):
    assert tables()[-1] == doctor_ros.__name__
    answers = list(examine(doctor_ros.__name__, None, lambda title: None))
    assert {answer.section for answer in answers} == {SECTION}
    assert [answer.name for answer in answers] == [check.name for check in checks(facts)]
    bad = [answer for answer in answers if answer.finding.mark in (Mark.PROBLEM, Mark.SKIPPED)]
    assert not bad


def test_the_command_ends_with_1_and_names_what_it_could_not_look_at():
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, "doctor", "prototype_p1", "--json"],
        env={**os.environ, "RMW_IMPLEMENTATION": "rmw_none_cpp"},
        capture_output=True,
        text=True,
        timeout=4 * DEADLINE,
        check=False,
    )
    marks = {check["name"]: check["mark"] for check in json.loads(done.stdout)["checks"]}
    assert done.returncode == 1
    assert marks["ros.middleware"] == "problem"
    assert marks["ros.two_processes"] == "skipped"
    assert marks["ros.domain"] == "ok"


# --- the page ------------------------------------------------------------------------------------


def test_the_page_names_lines_that_the_doctor_prints(facts):
    page = (Path(__file__).parents[2] / "docs/troubleshooting.md").read_text(encoding="utf-8")
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("|")][2:]
    named = {title for row in rows for title in row[-1].split(", ")}
    tables = (doctor_install, doctor_gripper, doctor_ros)
    titles = {check.title for table in tables for check in table.checks(facts)}
    assert len(rows) > 10
    assert {len(row) for row in rows} == {4}
    assert named <= titles | {"ROS 2", "none"}
