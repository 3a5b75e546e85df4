# SPDX-License-Identifier: Apache-2.0
"""The doctor's checks of the shared memory through which Fast DDS passes messages. Knows no ROS.

Fast DDS keeps a file for each process and a lock on another beside it. A process that was killed
leaves its files behind, without the lock.
"""

from __future__ import annotations

import os
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from spiral_gripper.doctor.checks import Facts, Finding, Mark

FOLDER = "dev/shm"
# The lock of a process's segment, of a port it listens to alone, of one it shares.
_LOCK = re.compile(r"fastrtps_(port\d+|[0-9a-f]{16})_[es]l")
MEGABYTE = 1_000_000
# A process of ours takes half of the first; a full folder kills processes that write to it.
TIGHT, TOO_LITTLE = 32 * MEGABYTE, 2 * MEGABYTE


@dataclass(frozen=True, slots=True)
class SharedMemory:
    """The content of the folder for shared memory.

    Attributes:
        folder: that folder.
        free: room in it [bytes].
        in_use: names of Fast DDS's locks that a running process holds.
        left: those that none holds any more.
        foreign: names of those of both that belong to other users.
    """

    folder: Path
    free: int
    in_use: tuple[str, ...]
    left: tuple[str, ...]
    foreign: tuple[str, ...]

    @classmethod
    def of(cls, facts: Facts) -> SharedMemory | None:
        """Return what is there now; None where there is no such folder."""
        folder = facts.root / FOLDER
        if not folder.is_dir():
            return None
        held = _held_files(facts)
        in_use: list[str] = []
        left: list[str] = []
        foreign: list[str] = []
        for path in sorted(folder.iterdir()):
            try:
                status = path.stat()
            except OSError:  # gone in the meantime
                continue
            if not _LOCK.fullmatch(path.name):
                continue
            used = held is None or (status.st_dev, status.st_ino) in held
            (in_use if used else left).append(path.name)
            if status.st_uid != os.getuid():
                foreign.append(path.name)
        free = shutil.disk_usage(folder).free
        return cls(folder, free, tuple(in_use), tuple(left), tuple(foreign))


def check_room(facts: Facts) -> Finding:
    """Check whether there is room for messages in shared memory."""
    memory = SharedMemory.of(facts)
    return _NONE if memory is None else room_finding(memory, root=_is_root())


def room_finding(memory: SharedMemory, *, root: bool = False) -> Finding:
    """Judge the room in shared memory.

    Args:
        memory: the content.
        root: whether the user is root and needs no sudo.
    """
    text = f"{memory.free / MEGABYTE:,.0f} MB free in {memory.folder}"
    if memory.free >= TIGHT:
        return Finding(Mark.OK, text)
    return Finding(
        Mark.PROBLEM if memory.free < TOO_LITTLE else Mark.WARNING,
        text,
        "A ROS 2 process takes half a megabyte, and dies where there is none. Start the container "
        "with --shm-size=512m, or make the folder larger:",
        (f"{'' if root else 'sudo '}mount -o remount,size=512M {memory.folder}",),
    )


def check_leftovers(facts: Facts) -> Finding:
    """Check whether ended processes or other users have left files there."""
    memory = SharedMemory.of(facts)
    if memory is None:
        return _NONE
    return leftovers_finding(memory, _cleaner(facts), root=_is_root())


def leftovers_finding(memory: SharedMemory, cleaner: str, *, root: bool = False) -> Finding:
    """Judge what lies in shared memory.

    Args:
        memory: what lies there.
        cleaner: the command that removes what no process uses.
        root: whether it is root who asks, and needs no sudo.
    """
    if set(memory.foreign) & set(memory.in_use):
        return Finding(
            Mark.WARNING,
            "nodes of other users run on this machine",
            "Nodes of different users find each other, but messages between them may not arrive. "
            "Run all as one user, or all of them without shared memory:",
            ("export FASTDDS_BUILTIN_TRANSPORTS=UDPv4",),
        )
    if memory.left:
        others = set(memory.foreign) & set(memory.left)
        whose = f", {len(others)} of them of other users" if others else ""
        return Finding(
            Mark.WARNING,
            f"{len(memory.left)} locks of Fast DDS are left from processes that were killed{whose}",
            "They take room, make new nodes print open_and_lock_file failed, and can stop messages "
            "if they are another user's. Remove what no process uses:",
            (f"sudo {cleaner}" if others and not root else cleaner,),
        )
    segments = sum("port" not in name for name in memory.in_use)
    return Finding(Mark.OK, f"nothing left behind; in use by {segments} processes")


_NONE = Finding(Mark.INFO, f"there is no /{FOLDER} here; messages take the network")


def _is_root() -> bool:
    return os.geteuid() == 0


def _cleaner(facts: Facts) -> str:
    """Return the command that cleans up, with its path where it comes with the wheels."""
    own = facts.prefix / "bin" / "fastdds"
    return f"{own if own.is_file() else 'fastdds'} shm clean"


def _held_files(facts: Facts) -> set[tuple[int, int]] | None:
    """Return device and inode of the files that processes hold locks on; None if that is hidden."""
    try:
        lines = (facts.root / "proc/locks").read_text().splitlines()
    except OSError:
        return None
    found = (re.search(r" ([0-9a-f]+):([0-9a-f]+):(\d+) ", line) for line in lines)
    return {(os.makedev(int(m[1], 16), int(m[2], 16)), int(m[3])) for m in found if m is not None}
