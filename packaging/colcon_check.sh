#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Build the tree with colcon against the ROS 2 wheels, isolated, merged and symlinked, as a ROS user
# does with a normal installation; check each. Everything stays in .colcon/ at the root.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
scratch=$root/.colcon
venv=$scratch/venv
step() { sh "$root/packaging/step.sh" "$scratch/$1.log" "${@:2}"; }

if [ ! -x "$venv/bin/pip" ]; then
  sh "$root/packaging/check_tools.sh" "${PYTHON:-python3}"
  step venv "colcon: creating a virtual environment" "${PYTHON:-python3}" -m venv "$venv"
fi
if [ ! "$venv/.installed" -nt "$root/pyproject.toml" ]; then
  step tools "colcon: installing colcon" \
    "$venv/bin/pip" install colcon-common-extensions 'setuptools<80' 'tomli; python_version < "3.11"'
  for what in build run; do
    "$venv/bin/python" "$root/packaging/requirements.py" $what
  done >"$scratch/requirements.txt"
  step wheels "colcon: installing the ROS 2 wheels" "$venv/bin/pip" install -r "$scratch/requirements.txt"
  touch "$venv/.installed"
fi

set +u
# shellcheck source=/dev/null
. "$venv/bin/activate"
set -u
export AMENT_PREFIX_PATH=$VIRTUAL_ENV
for layout in isolated merge symlink; do
  workspace=$scratch/$layout
  rm -rf "$workspace"
  case $layout in
    isolated) flags=() ;;
    *) flags=("--$layout-install") ;;
  esac
  # Run from the workspace, and the sources given: as in a workspace with this repository in src/.
  mkdir -p "$workspace"
  step "build-$layout" "colcon: build, $layout" sh -c 'cd "$1" && shift && "$@"' - "$workspace" \
    colcon --log-base "$workspace/log" build --base-paths "$root" "${flags[@]}" \
    --cmake-args -DCMAKE_PROJECT_INCLUDE="$root/packaging/ros_wheels.cmake"
  step "check-$layout" "colcon: check, $layout" bash -c \
    'set -e; . "$1/setup.bash"; exec python "$2/packaging/colcon_smoke.py" "$1" "$2"' - \
    "$workspace/install" "$root"
done
