#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# <prefix>/lib/<package>/<executable>, where ros2 run and ros2 launch look -> pip's <prefix>/bin/<executable>
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
exec "$here/../../bin/$(basename -- "$0")" "$@"
