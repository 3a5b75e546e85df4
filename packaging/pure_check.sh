#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Build and test the mechanics and the edge where there is no ROS: a pure wheel in an environment of
# its own.  Usage: pure_check.sh [lower-bounds]; then with the oldest dependencies allowed.
set -eu
root=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)
cd "$root"
name=pure${1:+-$1}
scratch=.make/$name
python=$scratch/venv/bin/python
step() { log=$1; shift; sh packaging/step.sh "$scratch/$log.log" "$@"; }
export SPIRAL_WITHOUT_ROS=1

if [ ! -x "$scratch/venv/bin/pip" ]; then
  sh packaging/check_tools.sh "${PYTHON:-python3}"
  step venv "$name: creating a virtual environment" "${PYTHON:-python3}" -m venv "$scratch/venv"
fi
: >"$scratch/constraints.txt"
if [ "${1:-}" = lower-bounds ]; then
  step tomli "$name: preparing" "$python" -m pip install 'tomli; python_version < "3.11"'
  "$python" packaging/requirements.py lower-bounds >"$scratch/constraints.txt"
fi
step install "$name: installing without ROS" \
  "$python" -m pip install --force-reinstall --constraint "$scratch/constraints.txt" '.[test]'

"$python" - <<'PYTHON'
from importlib import metadata

distribution = metadata.distribution("spiral-gripper")
assert "Tag: py3-none-any" in distribution.read_text("WHEEL"), "the wheel is not a pure one"
ros = sorted(d.name for d in metadata.distributions() if d.name.startswith("ros-"))
assert not ros, f"ROS came along: {ros}"
packages = {path.parts[0] for path in distribution.files if path.suffix == ".py"}
assert packages == {"spiral_core", "spiral_gripper"}, f"not the core and the edge: {packages}"
PYTHON
step compile "$name: compiling the numerical kernels" "$python" packaging/compile_kernels.py
# --pyargs: the doctests of the installed packages, not those of the folders beside this one.
"$scratch/venv/bin/pytest" --numprocesses=auto --dist=loadfile -m "not slow" --pyargs spiral_core spiral_gripper tests/core tests/edge
