#!/usr/bin/env bash
# Runs one of the example programs and checks the numbers that it prints.
#
#   check.sh EXAMPLE PROGRAM
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
arguments=()
[ "$1" = render_bin ] && arguments=("$work")
"$2" "${arguments[@]}" >"$work/output" 2>&1 || { cat "$work/output"; exit 1; }

# A number of the output has the name of the words before it: value("error") of "error 1.5 mm" is 1.5.
has() {
  awk 'function value(name) { return match($0, name ":? *-?[0-9.]+") ? substr($0, RSTART + length(name) + 1) + 0 : -1 }
    '"$1"'
    END { exit !('"$2"') }' "$work/output"
}

# Bytes of a file; 0 if it is missing.
bytes() { stat -c %s "$work/$1" 2>/dev/null || echo 0; }

case "$1" in
  render_bin)
    # All 20 instances are in the bin. Most are in sight. A picture of one color has 2 kB.
    has '/visible/ { ++count; sight += value("visible") > 50 } /reading/ { share = value("reading") }' \
      'count == 20 && sight >= 12 && share > 20 && share < 60' &&
      [ "$(bytes color.png)" -gt 20000 ] && [ "$(bytes depth.png)" -gt 60000 ] && exit 0
    ;;
  estimate_poses)
    # All five brackets are found, each within 5 mm of a true pose.
    has '/score/ { ++count; right += value("error") >= 0 && value("error") < 5 }' 'count == 5 && right == 5' && exit 0
    ;;
  plan_and_execute_grasp)
    has '/^grasp/ { planned = value("score") > 0.3 } /^failure: none$/ { picked = 1 } /placed/ { error = value("error of") }
         /^left/ { left = value("bin") }' 'planned && picked && left == 5 && error >= 0 && error < 10' && exit 0
    ;;
  own_estimator)
    # All five rings are found, each within 2 mm.
    has '/^ring/ { ++count; right += value("error") >= 0 && value("error") < 2 }' 'count == 5 && right == 5' && exit 0
    ;;
esac
echo "$1: wrong result:"
cat "$work/output"
exit 1
