# SPDX-License-Identifier: Apache-2.0
"""QoS profiles of the node's topics, with their reasons."""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

# Newest wins: what came before the newest estimate is of no use to anyone. Best effort hears
# reliable publishers and best-effort ones.
NEWEST = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.BEST_EFFORT,
    durability=DurabilityPolicy.VOLATILE,
)
# Late subscribers get the newest message too: a display that starts after the node.
LATEST = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
# For who listens now: a command or a set-point that was latched before is no sign of life.
UNLATCHED = QoSProfile(depth=1)
# Reliable, so that subscribers of either kind hear it; a late one has the next in a moment.
MEASUREMENTS = QoSProfile(depth=5)
# Requests wait their turn: 20 goals at once must not push each other out, as with a depth of 10.
REQUESTS = QoSProfile(depth=200)
# A regulator that requests liveliness is notified by the middleware when no command has come for
# this time [s], whether the node was killed, hangs, was deactivated or its simulated clock stands
# still: twice the period of the slowest publish.rate.
COMMAND_LEASE = 2.0
# Liveliness by topic: only a command counts as a sign of life, not a process that merely exists.
# No deadline: an inactive node is silent on purpose, so that another may command, and a deadline
# that is broken on purpose promises nothing. Volatile: a regulator that joins later must not take
# an old set-point for a new one.
COMMAND = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
    liveliness_lease_duration=Duration(seconds=COMMAND_LEASE),
)
