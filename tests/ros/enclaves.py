# SPDX-License-Identifier: Apache-2.0
"""The SROS2 policies, read as sros2 reads them, beside what running nodes do, in the same terms.

A right is a pair of what one may do and the full name of a topic or a service. An action is the
services and topics that it consists of. sros2 turns each right into DDS topics; with its profiles'
names, these are the rules of its schema (version 0.2.0) and of its template for permissions:

- a name that begins with "/" stands as it is, "~" stands for the node's, others follow `ns`;
- all profiles of an enclave are of one process, and its rights are theirs together.
"""

from fnmatch import fnmatchcase
from itertools import chain
from pathlib import Path
from xml.etree import ElementTree

SECURITY = Path(__file__).parents[2] / "spiral_gripper_ros" / "security"
POLICY, SIMULATION = SECURITY / "policy.xml", SECURITY / "simulation.xml"
PREFIX = "/spiral_gripper/"
VERSION = "0.2.0"
# What the schema allows: the attributes of an element, and the elements in it.
SCHEMA = {
    "policy": ({"version"}, {"enclaves"}),
    "enclaves": (set(), {"enclave"}),
    "enclave": ({"path"}, {"profiles"}),
    "profiles": (set(), {"profile"}),
    "profile": ({"ns", "node"}, {"topics", "services", "actions"}),
    "topics": ({"publish", "subscribe"}, {"topic"}),
    "services": ({"reply", "request"}, {"service"}),
    "actions": ({"execute", "call"}, {"action"}),
    "topic": (set(), set()),
    "service": (set(), set()),
    "action": (set(), set()),
}
RIGHTS = ("publish", "subscribe", "reply", "request")
_ACTION_SERVICES = ("send_goal", "cancel_goal", "get_result")
_ACTION_TOPICS = ("feedback", "status")
# How a right on an action's services and one on its topics follow from the right on the action.
_OF_ACTIONS = {"execute": ("reply", "publish"), "call": ("request", "subscribe")}
_GRAPH = dict(zip(RIGHTS, ("publisher", "subscriber", "service", "client"), strict=True))


def rights_by_enclave(namespace="/", files=(POLICY, SIMULATION)):
    """Return the rights of each enclave, by the last part of its path, for a namespace."""
    return {
        enclave.get("path").removeprefix(PREFIX): {
            right
            for profile in enclave.find("profiles")
            for group in profile
            for entry in group
            for right in _rights(profile, group, entry, namespace)
        }
        for file in files
        for enclave in _read(file).find("enclaves")
    }


def profiles(enclave, files=(POLICY, SIMULATION)):
    """Return the names of the nodes of an enclave."""
    return [
        profile.get("node")
        for file in files
        for profile in _read(file).iterfind(f".//enclave[@path='{PREFIX}{enclave}']//profile")
    ]


def action_rights(kind, name):
    """Return the rights that one on an action consists of: ``execute`` or ``call``."""
    on_services, on_topics = _OF_ACTIONS[kind]
    return {
        *((on_services, f"{name}/_action/{service}") for service in _ACTION_SERVICES),
        *((on_topics, f"{name}/_action/{topic}") for topic in _ACTION_TOPICS),
    }


def used_rights(looker, *names):
    """Return what nodes of the looker's namespace do, as the looker sees it; nothing if unseen."""
    namespace = looker.get_namespace()
    known = set(looker.get_node_names_and_namespaces())
    return {
        (right, topic)
        for name in names
        if (name, namespace) in known
        for right, kind in _GRAPH.items()
        for topic, _ in getattr(looker, f"get_{kind}_names_and_types_by_node")(name, namespace)
    }


def permits(rights, right):
    """Return whether rights permit one, wildcards included."""
    return any(right[0] == kind and fnmatchcase(right[1], name) for kind, name in rights)


def _read(file):
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    root = ElementTree.parse(file, parser).getroot()
    assert root.get("version") == VERSION, file
    assert all(type(enclave.tag) is str for enclave in root.find("enclaves")), (
        f"{file}: sros2 takes a comment directly below enclaves for an enclave"
    )
    for parent in root.iter():
        for comment in [child for child in parent if type(child.tag) is not str]:
            parent.remove(comment)
    for element in root.iter():
        attributes, children = SCHEMA[element.tag]
        assert set(element.attrib) <= attributes, f"{file}: {element.tag} {element.attrib}"
        assert {child.tag for child in element} <= children, f"{file}: {element.tag}"
        assert children or element.text.strip(), f"{file}: an empty {element.tag}"
    return root


def _rights(profile, group, entry, namespace):
    assert profile.get("ns") == "/", "documentation says to replace every ns"
    ns = namespace.rstrip("/")
    name = entry.text
    if name.startswith("~"):
        name = f"{ns}/{profile.get('node')}{name[1:]}"
    elif not name.startswith("/"):
        name = f"{ns}/{name}"
    assert set(group.attrib.values()) == {"ALLOW"}, "the default is to deny"
    return chain.from_iterable(
        action_rights(kind, name) if kind in _OF_ACTIONS else {(kind, name)}
        for kind in group.attrib
    )
