# SPDX-License-Identifier: Apache-2.0
"""The doctor's checks of the domain and the range of discovery. No ROS."""

from __future__ import annotations

import re

from spiral_gripper.doctor.checks import Facts, Finding, Mark

DOMAIN = "ROS_DOMAIN_ID"
# A domain's ports begin at 7400 + 250 * domain; forty processes take a hundred of them. The last
# port there is, 65535, ends the domains.
FIRST_PORT, PORTS_PER_DOMAIN, PORTS_USED = 7400, 250, 100
HIGHEST_DOMAIN = 232
# What Linux gives to outgoing connections unless it is told otherwise.
OUTGOING_PORTS = (32768, 60999)

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
LOCALHOST_ONLY = "ROS_LOCALHOST_ONLY"
PEERS = "ROS_STATIC_PEERS"
RANGES = {
    "SUBNET": "nodes on this machine and on its network hear each other",
    "LOCALHOST": "nodes on this machine find each other, and whoever names it in ROS_STATIC_PEERS",
    "OFF": "no node hears another, not even on this machine",
    "SYSTEM_DEFAULT": "the middleware's own settings say who hears whom",
}


def check_domain(facts: Facts) -> Finding:
    """Check whether the domain is a number whose ports no outgoing connection uses."""
    text = facts.environ.get(DOMAIN, "")
    if not text:
        return Finding(Mark.OK, f"0, shared with everyone else who has not set {DOMAIN}")
    first, last = outgoing_ports(facts)
    advice, command = _mend(highest_safe_domain(facts))
    if not re.fullmatch(r"[0-9]{1,9}", text) or int(text) > HIGHEST_DOMAIN:
        wrong = f"{DOMAIN}={text} is not a number from 0 to {HIGHEST_DOMAIN}"
        return Finding(Mark.PROBLEM, wrong, advice, (command,))
    port = FIRST_PORT + PORTS_PER_DOMAIN * int(text)
    if first - PORTS_USED < port <= last:
        return Finding(
            Mark.WARNING,
            f"{text}, whose ports from {port} on belong to those of outgoing connections here "
            f"({first} to {last}): now and then a node will not start",
            advice,
            (command,),
        )
    return Finding(Mark.OK, f"{text}, from {DOMAIN}: only nodes with the same number are heard")


def highest_safe_domain(facts: Facts) -> int:
    """Return the last domain below the ports of outgoing connections; negative: there is none."""
    return (outgoing_ports(facts)[0] - FIRST_PORT - PORTS_USED) // PORTS_PER_DOMAIN


def outgoing_ports(facts: Facts) -> tuple[int, int]:
    """Return the first and the last port that this machine gives to outgoing connections."""
    try:
        text = (facts.root / "proc/sys/net/ipv4/ip_local_port_range").read_text()
        first, last = (int(part) for part in text.split())
    except (OSError, ValueError):  # not Linux, or hidden in a container
        return OUTGOING_PORTS
    return first, last


def _mend(highest: int) -> tuple[str, str]:
    """Return what to do about a domain, in words and as a command."""
    if highest >= 0:
        return f"Choose one from 0 to {highest}:", f"export {DOMAIN}={highest // 2}"
    ports = " ".join(str(port) for port in OUTGOING_PORTS)
    return (
        "All domains' ports are among them. To give outgoing connections the usual ones:",
        f"sudo sysctl -w net.ipv4.ip_local_port_range='{ports}'",
    )


def check_discovery(facts: Facts) -> Finding:
    """Explain what the variables of discovery say, and whether they contradict each other."""
    wanted = facts.environ.get(RANGE, "")
    local = facts.environ.get(LOCALHOST_ONLY, "")
    if local == "1":
        ignored = [name for name in (RANGE, PEERS) if facts.environ.get(name)]
        advice = f"The newer {RANGE}=LOCALHOST says the same"
        if ignored:
            advice = f"{' and '.join(ignored)} are ignored because of it"
        return Finding(
            Mark.WARNING if ignored else Mark.INFO,
            f"{LOCALHOST_ONLY}=1: {RANGES['LOCALHOST']}",
            f"{advice}. To use one variable only:",
            (f"unset {LOCALHOST_ONLY}; export {RANGE}={wanted or 'LOCALHOST'}",),
        )
    if wanted and wanted not in RANGES:
        return Finding(
            Mark.WARNING,
            f"{RANGE}={wanted} is unknown and counts as LOCALHOST: {RANGES['LOCALHOST']}",
            f"Choose one of {', '.join(RANGES)}:",
            (f"export {RANGE}=SUBNET",),
        )
    if wanted == "OFF":
        advice = "Nothing will reach the node. For nodes on this machine:"
        command = f"export {RANGE}=LOCALHOST"
        return Finding(Mark.WARNING, f"OFF, from {RANGE}: {RANGES['OFF']}", advice, (command,))
    peers = facts.environ.get(PEERS, "")
    more = f"; besides {peers}, from {PEERS}" if peers else ""
    origin = f"from {RANGE}" if wanted else "the default"
    return Finding(Mark.OK, f"{wanted or 'SUBNET'}, {origin}: {RANGES[wanted or 'SUBNET']}{more}")
