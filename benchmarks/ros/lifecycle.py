# SPDX-License-Identifier: Apache-2.0
"""Through the life cycle, again and again: what stays behind."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState

from benchmarks.results import MEGABYTE, Section, Table
from benchmarks.ros.effort import NodeEffort
from benchmarks.ros.probe import Probe
from benchmarks.ros.session import PROMPT, process
from benchmarks.ros.sweep import radius_sweep
from benchmarks.ros.usage_of_process import Usage, usage

NODE = "spiral_gripper"
UP = (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE)
DOWN = (Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_CLEANUP)
# After so many cycles every pool and cache has its size.
WARM_UP = 10
TIMEOUT = 30.0
# News of the graph takes a tenth of this [s].
QUIET = 0.5


@dataclass(frozen=True, slots=True)
class Left:
    """What there is after a cycle, the gripper unloaded.

    Args:
        usage: of the process.
        entities: publishers, subscriptions and services that the graph knows of the node.
        duration: of the cycle [s].
    """

    usage: Usage
    entities: int
    duration: float


class LifecycleProbe(Probe):
    """A probe that asks for transitions too."""

    def __init__(self, namespace: str) -> None:
        super().__init__(namespace)
        self._changes = self.node.create_client(ChangeState, f"{NODE}/change_state")

    def is_ready(self) -> bool:
        """Return whether transitions can be asked for."""
        return bool(self._changes.service_is_ready())

    def change(self, transition: int) -> None:
        """Ask for a transition and wait for it."""
        request = ChangeState.Request(transition=Transition(id=transition))
        future: Any = self._changes.call_async(request)
        self.spin_until(future.done, TIMEOUT)
        if not future.result().success:
            raise RuntimeError(f"transition {transition} failed")

    def settled_entities(self) -> int:
        """Return how many names the node has in the graph, once that does not change any more."""
        count = -1
        while count != (count := self.entities()):
            self.spin_until_time(time.perf_counter() + QUIET)
        return count

    def entities(self) -> int:
        """Return how many names the node has in the graph now."""
        named = (NODE, self.node.get_namespace())
        return sum(
            len(found)
            for found in (
                self.node.get_publisher_names_and_types_by_node(*named),
                self.node.get_subscriber_names_and_types_by_node(*named),
                self.node.get_service_names_and_types_by_node(*named),
            )
        )


def measure(effort: NodeEffort) -> Section:
    """Configure, activate, wrap, deactivate, clean up; look at the process after each cycle."""
    sweep, probe = radius_sweep(), LifecycleProbe("/lifecycle")
    left: list[Left] = []
    looked_at = (0, min(WARM_UP, effort.cycles) - 1, effort.cycles - 1)
    with process("/lifecycle", PROMPT | {"autostart": False}) as node:
        probe.spin_until(probe.is_ready)
        for cycle in range(effort.cycles):
            start = time.perf_counter()
            for transition in UP:
                probe.change(transition)
            probe.approach(sweep)
            for transition in DOWN:
                probe.change(transition)
            duration = time.perf_counter() - start
            entities = probe.settled_entities() if cycle in looked_at else 0
            left.append(Left(usage(node.pid), entities, duration))
    probe.close()
    warm, last = left[looked_at[1]], left[-1]
    return Section(
        (
            Table(
                f"{effort.cycles} times configure, activate, wrap, deactivate, clean up",
                ("after", "resident memory", "threads", "open files", "entities"),
                tuple(_row(cycle + 1, left[cycle]) for cycle in looked_at),
                "Entities: publishers, subscriptions and services that the graph knows of the "
                "unloaded node. A cycle takes "
                f"{np.median([each.duration for each in left]):.2f} s (median).",
            ),
        ),
        {
            "memory_growth_mb": (last.usage.memory - warm.usage.memory) / MEGABYTE,
            "thread_growth": float(last.usage.threads - warm.usage.threads),
            "file_growth": float(last.usage.files - warm.usage.files),
            "entity_growth": float(last.entities - left[0].entities),
            "cycle": float(np.median([each.duration for each in left])),
        },
    )


def _row(cycles: int, left: Left) -> tuple[str, ...]:
    found = left.usage
    memory = f"{found.memory / MEGABYTE:.1f} MB"
    return (str(cycles), memory, str(found.threads), str(found.files), str(left.entities))
