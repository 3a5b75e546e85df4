#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Say in one message what is missing before anything is installed.  Usage: check_tools.sh PYTHON
set -u
python=$1
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)

fail() {
  printf '\nCannot set up the environment: %s\n' "$1" >&2
  shift
  for line in "$@"; do printf '  %s\n' "$line" >&2; done
  exit 1
}

command -v "$python" >/dev/null 2>&1 ||
  fail "there is no '$python'." "Install Python 3.10 or newer, or choose one: make PYTHON=/path/to/python3"

version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])') ||
  fail "'$python' does not run."
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' ||
  fail "'$python' is Python $version, 3.10 or newer is needed." "Choose another: make PYTHON=python3.12"
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
  fail "Python $version has no venv module." "Debian and Ubuntu: apt install python3-venv"

# The messages are compiled, the rest is Python.
[ "$("$python" "$here/ros_metadata.py")" = yes ] || exit 0

compiler=
for candidate in "${CXX:-c++}" ${CXX:-g++ clang++}; do
  command -v "${candidate%% *}" >/dev/null 2>&1 && compiler=$candidate && break
done
[ -n "$compiler" ] ||
  fail "there is no C++ compiler${CXX:+ '$CXX'}; the ROS 2 messages are compiled." \
    "Debian and Ubuntu: apt install g++" \
    "Or the mechanics alone, without ROS: SPIRAL_WITHOUT_ROS=1 make test"
"$python" - <<'PYTHON' ||
import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))
PYTHON
  fail "the headers of Python $version are missing; the ROS 2 messages are compiled." \
    "Debian and Ubuntu: apt install python3-dev" \
    "Or the mechanics alone, without ROS: SPIRAL_WITHOUT_ROS=1 make test"
