# SPDX-License-Identifier: Apache-2.0
"""The doctor's check of the settings of SROS 2. No ROS."""

from __future__ import annotations

from pathlib import Path

from spiral_gripper.doctor.checks import Facts, Finding, Mark

ENABLE, STRATEGY = "ROS_SECURITY_ENABLE", "ROS_SECURITY_STRATEGY"
KEYSTORE, ENCLAVE = "ROS_SECURITY_KEYSTORE", "ROS_SECURITY_ENCLAVE_OVERRIDE"
OWN_ENCLAVE = "/spiral_gripper_doctor"


def check_security(facts: Facts) -> Finding:
    """Check whether security is on, and whether its keys are in the folder of the settings."""
    enable = facts.environ.get(ENABLE, "")
    if enable not in ("", "false", "true"):
        return Finding(
            Mark.WARNING,
            f"off: {ENABLE}={enable} does not turn it on, only true does",
            "If it is to be on:",
            (f"export {ENABLE}=true",),
        )
    if enable != "true":
        return Finding(Mark.INFO, "off: anyone who reaches the domain can command a gripper")
    enforced = facts.environ.get(STRATEGY) == "Enforce"
    keystore = facts.environ.get(KEYSTORE, "")
    enclaves = Path(keystore) / "enclaves"
    if not keystore or not enclaves.is_dir():
        return Finding(
            Mark.PROBLEM if enforced else Mark.WARNING,
            f"on, but {KEYSTORE}={keystore} is no keystore: "
            + ("no node will start" if enforced else f"nodes run without it ({STRATEGY})"),
            "Name the folder that ros2 security create_keystore has made:",
            (f"export {KEYSTORE}=~/spiral_gripper_keys",),
        )
    if not enforced:
        text = f"on, but {STRATEGY} is not Enforce: a node without keys of its own runs unsecured"
        return Finding(Mark.WARNING, text, "To prevent its start:", (f"export {STRATEGY}=Enforce",))
    own = facts.environ.get(ENCLAVE, "/").strip("/")
    if not (enclaves / own / "cert.pem").is_file():
        return Finding(
            Mark.SKIPPED,
            f"on, with {keystore}; the doctor has no keys of its own, and cannot listen or send",
            "To give the doctor keys for the check (they allow everything):",
            (
                f"ros2 security create_enclave {keystore} {OWN_ENCLAVE}",
                f"export {ENCLAVE}={OWN_ENCLAVE}",
            ),
        )
    return Finding(Mark.OK, f"on, with the keys in {enclaves / own}")
