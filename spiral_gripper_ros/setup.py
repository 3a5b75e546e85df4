# SPDX-License-Identifier: Apache-2.0
"""For colcon build only: `pip install .` uses the pyproject.toml of the repository's root."""

from __future__ import annotations

from glob import glob
from xml.etree import ElementTree

from setuptools import find_packages, setup

NAME = "spiral_gripper_ros"
SHARED = {
    "config": "config/*.yaml",
    "launch": "launch/*.py",
    "rviz": "rviz/*.rviz",
    "urdf": "urdf/*",
    "security": "security/*.xml",
    "systemd": "systemd/*.service",
}

setup(
    name=NAME,
    version=ElementTree.parse("package.xml").findtext("version"),
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *((f"share/{NAME}/{name}", sorted(glob(files))) for name, files in SHARED.items()),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "spiral_gripper_node = spiral_gripper_ros.node.main:main",
            "spiral_gripper_demo = spiral_gripper_ros.tools.demo:main",
            "spiral_gripper_simulator = spiral_gripper_ros.simulation.main:main",
            "spiral_gripper_regulator = spiral_gripper_ros.regulators.main:main",
        ]
    },
)
