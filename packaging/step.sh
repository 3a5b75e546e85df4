#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Run a command with one line on the screen and the rest in a log; on failure show the log's end.
# Usage: step.sh LOG "what is going on" COMMAND [ARGUMENT ...]
set -u
log=$1 what=$2
shift 2
mkdir -p "$(dirname -- "$log")"
start=$(date +%s)
printf '%s ... ' "$what"
"$@" >"$log" 2>&1 </dev/null
status=$?
if [ "$status" -eq 0 ]; then
  printf 'done (%d s)\n' $(($(date +%s) - start))
  exit 0
fi
printf 'failed\n\n'
tail -n 30 "$log" | cut -c 1-240
printf '\n%s failed with status %d; the whole log: %s\n' "$1" "$status" "$log"
exit "$status"
