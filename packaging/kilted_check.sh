#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Build against the wheels of ROS 2 Kilted in an environment of its own, and test the node there.
# Usage: kilted_check.sh [PYTEST_ARGUMENT ...]; all tests of the node if none is given.
set -eu
root=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)
cd "$root"
scratch=.make/kilted
python=$scratch/venv/bin/python
step() { log=$1; shift; sh packaging/step.sh "$scratch/$log.log" "$@"; }
export SPIRAL_ROS_DISTRO=kilted

if [ ! -x "$scratch/venv/bin/pip" ]; then
  sh packaging/check_tools.sh "${PYTHON:-python3}"
  step venv "kilted: creating a virtual environment" "${PYTHON:-python3}" -m venv "$scratch/venv"
fi
step tomli "kilted: preparing" "$python" -m pip install 'scikit-build-core>=1.1' 'tomli; python_version < "3.11"'
for what in build run; do "$python" packaging/requirements.py $what; done >"$scratch/requirements.txt"
step wheels "kilted: installing the wheels of ROS 2" "$python" -m pip install -r "$scratch/requirements.txt"
# Without isolation: the build requirements that pyproject.toml states are those of Jazzy.
step install "kilted: compiling the messages" \
  "$python" -m pip install --no-build-isolation -e '.[test]'
[ $# -gt 0 ] || set -- spiral_gripper_ros/spiral_gripper_ros tests/ros
exec "$scratch/venv/bin/pytest" "$@"
