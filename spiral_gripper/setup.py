# SPDX-License-Identifier: Apache-2.0
"""For colcon build only: `pip install .` uses the pyproject.toml of the repository's root."""

from __future__ import annotations

from xml.etree import ElementTree

from setuptools import find_packages, setup

NAME = "spiral_gripper"

setup(
    name=NAME,
    version=ElementTree.parse("package.xml").findtext("version"),
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "*.pyi", "config/*.*", "config/tubing/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    entry_points={"console_scripts": ["spiral-gripper = spiral_gripper.cli.main:main"]},
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
)
