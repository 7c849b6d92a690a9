#!/usr/bin/env bash
# Runs a check on planted faults. Fails unless the check exits with 1 and prints the fault.
#
#   finds.sh FAULT COMMAND...      FAULT is an extended regular expression
set -u
fault=$1
shift
output=$("$@" 2>&1)
status=$?
printf '%s\n' "$output"
[ "$status" = 1 ] || { echo "FAIL: exit status $status, expected 1"; exit 1; }
grep -qE -- "$fault" <<<"$output" || { echo "FAIL: no line with '$fault'"; exit 1; }
