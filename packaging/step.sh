#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Run a command with one line on the screen and the rest in a log; on failure show the log's end.
# Usage: step.sh LOG "what is going on" COMMAND [ARGUMENT ...]
set -u
log=$1 what=$2
shift 2
mkdir -p "$(dirname -- "$log")"
start=$(date +%s)
printf '%s; log: %s ... ' "$what" "$log"
clock=
if [ -t 1 ]; then # who waits at a terminal sees the seconds
  while sleep 1; do printf '\r%s; log: %s ... %d s ' "$what" "$log" $(($(date +%s) - start)); done &
  clock=$!
  trap 'kill "$clock" 2>/dev/null' EXIT
  trap 'exit 130' INT TERM # dash runs no EXIT trap when a signal ends it
fi
"$@" >"$log" 2>&1 </dev/null
status=$?
[ -z "$clock" ] || { kill "$clock"; printf '\r%s; log: %s ... ' "$what" "$log"; }
if [ "$status" -eq 0 ]; then
  printf 'done (%d s)\n' $(($(date +%s) - start))
  exit 0
fi
printf 'failed\n\n'
tail -n 30 "$log" | cut -c 1-240
printf '\n%s failed with status %d; the whole log: %s\n' "$1" "$status" "$log"
exit "$status"
